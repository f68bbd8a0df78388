#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace gluevo::vo {

/// Brightness 0 to 1 at (u, v), metres from a surface's corner.
using Pattern = std::function<double(double, double)>;

/// A pattern baked into a pyramid of 8-bit images, sampled trilinearly.
class Texture {
 public:
  /// A single gray.
  Texture();
  /// Bakes width x height metres with texels of `texel_m` metres (at most 16384 a side: larger
  /// texels are taken where there would be more), on `threads` threads.
  Texture(double width_m, double height_m, double texel_m, const Pattern& pattern, int threads);

  /// The brightness, 0 to 255, averaged over about `footprint_m` metres around (u, v); clamped at
  /// the edges. Continuous in all three arguments.
  float Sample(double u, double v, double footprint_m) const;

 private:
  struct Level {
    int columns = 1;
    int rows = 1;
    float texels_per_metre = 1.0F;
    std::vector<uint8_t> texels;
  };
  static float Bilinear(const Level& level, float u, float v);

  std::vector<Level> levels_;
  float texel_m_ = 1.0F;
};

}  // namespace gluevo::vo
