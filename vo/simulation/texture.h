#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace gluevo::simulation {

/// Brightness 0 to 1 at (u, v), metres from a surface's corner.
using Pattern = std::function<double(double, double)>;

/// A pattern baked into a pyramid of 8-bit images, sampled trilinearly. Copies share the images.
class Texture {
 private:
  struct Level {
    Level(int columns_in, int rows_in, double texel_m);
    /// Fills the padding with the values beside it.
    void Pad();

    int columns;
    int rows;
    int stride;  ///< Of rows in `texels`, which are padded by one texel at their ends.
    float last_column;
    float last_row;
    float texels_per_metre;
    std::vector<uint8_t> texels;
  };

 public:
  /// A single gray.
  Texture();
  /// Bakes width x height metres with texels of `texel_m` metres (at most 16384 a side: larger
  /// texels are taken where there would be more), on `threads` threads. `checkpoint`, where there
  /// is one, is called for each row, by all threads: what it throws is thrown here.
  Texture(double width_m, double height_m, double texel_m, const Pattern& pattern, int threads,
          const std::function<void()>& checkpoint = {});

  /// Samples at one footprint, for several places.
  class Sampler {
   public:
    /// The brightness, 0 to 255, averaged over the footprint around (u, v), metres; clamped at the
    /// edges. Continuous in u, v and the footprint.
    float Sample(float u, float v) const {
      const float value = Bilinear(*fine_, u, v);
      return part_ == 0.0F ? value : value + (Bilinear(*coarse_, u, v) - value) * part_;
    }
    /// The same for four places, with the same results.
    Eigen::Array4f Sample(const Eigen::Array4f& u, const Eigen::Array4f& v) const {
      Eigen::Array4f value = Bilinear(*fine_, u, v);
      if (part_ == 0.0F) return value;
      return value + (Bilinear(*coarse_, u, v) - value) * part_;
    }

   private:
    friend class Texture;
    Sampler(const Level& fine, const Level& coarse, float part)
        : fine_(&fine), coarse_(&coarse), part_(part) {}

    static float Bilinear(const Level& level, float u, float v) {
      const float x = std::clamp(u * level.texels_per_metre - 0.5F, 0.0F, level.last_column);
      const float y = std::clamp(v * level.texels_per_metre - 0.5F, 0.0F, level.last_row);
      const int column = static_cast<int>(x);
      const int row = static_cast<int>(y);
      const float a = x - static_cast<float>(column);
      const float b = y - static_cast<float>(row);
      const uint8_t* texel = &level.texels[static_cast<std::size_t>(row) * level.stride + column];
      const auto top0 = static_cast<float>(texel[0]);
      const auto top1 = static_cast<float>(texel[1]);
      const auto bottom0 = static_cast<float>(texel[level.stride]);
      const auto bottom1 = static_cast<float>(texel[level.stride + 1]);
      const float top = top0 + (top1 - top0) * a;
      const float bottom = bottom0 + (bottom1 - bottom0) * a;
      return top + (bottom - top) * b;
    }

    static Eigen::Array4f Bilinear(const Level& level, const Eigen::Array4f& u,
                                   const Eigen::Array4f& v) {
      const Eigen::Array4f x = (u * level.texels_per_metre - 0.5F).max(0.0F).min(level.last_column);
      const Eigen::Array4f y = (v * level.texels_per_metre - 0.5F).max(0.0F).min(level.last_row);
      const Eigen::Array4i column = x.cast<int>();
      const Eigen::Array4i row = y.cast<int>();
      const Eigen::Array4f a = x - column.cast<float>();
      const Eigen::Array4f b = y - row.cast<float>();
      Eigen::Array4i top0, top1, bottom0, bottom1;
      for (int i = 0; i < 4; ++i) {
        const uint8_t* const texel =
            &level.texels[static_cast<std::size_t>(row[i]) * level.stride + column[i]];
        top0[i] = texel[0];
        top1[i] = texel[1];
        bottom0[i] = texel[level.stride];
        bottom1[i] = texel[level.stride + 1];
      }
      const Eigen::Array4f left = top0.cast<float>();
      const Eigen::Array4f left_below = bottom0.cast<float>();
      const Eigen::Array4f top = left + (top1.cast<float>() - left) * a;
      const Eigen::Array4f bottom = left_below + (bottom1.cast<float>() - left_below) * a;
      return top + (bottom - top) * b;
    }

    const Level* fine_;
    const Level* coarse_;
    float part_;
  };

  /// For footprints of about 2^log2_footprint_m metres a side.
  Sampler At(float log2_footprint_m) const {
    const float level =
        std::clamp(log2_footprint_m - log2_texel_m_, 0.0F, static_cast<float>(levels_->size() - 1));
    const auto fine = static_cast<std::size_t>(level);
    return {(*levels_)[fine], (*levels_)[std::min(fine + 1, levels_->size() - 1)],
            level - static_cast<float>(fine)};
  }

 private:
  std::shared_ptr<const std::vector<Level>> levels_;  ///< Never absent.
  float log2_texel_m_ = 0.0F;
};

}  // namespace gluevo::simulation
