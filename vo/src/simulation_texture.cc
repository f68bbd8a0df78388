#include "simulation_texture.h"

#include <algorithm>
#include <cmath>

#include "parallel_for.h"

namespace gluevo::vo {

Texture::Texture() : levels_(1) { levels_[0].texels.assign(1, 128); }

Texture::Texture(double width_m, double height_m, double texel_m, const Pattern& pattern,
                 int threads) {
  constexpr double kMostTexels = 16384.0;
  texel_m = std::max(texel_m, std::max(width_m, height_m) / kMostTexels);
  texel_m_ = static_cast<float>(texel_m);
  Level base;
  base.columns = std::max(1, static_cast<int>(std::ceil(width_m / texel_m)));
  base.rows = std::max(1, static_cast<int>(std::ceil(height_m / texel_m)));
  base.texels_per_metre = static_cast<float>(1.0 / texel_m);
  base.texels.resize(static_cast<std::size_t>(base.columns) * base.rows);
  ParallelFor(base.rows, threads, [&](int row) {
    uint8_t* texels = &base.texels[static_cast<std::size_t>(row) * base.columns];
    for (int column = 0; column < base.columns; ++column) {
      const double value = pattern((column + 0.5) * texel_m, (row + 0.5) * texel_m);
      texels[column] = static_cast<uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
    }
  });
  levels_.push_back(std::move(base));
  while (levels_.back().columns > 1 && levels_.back().rows > 1) {
    const Level& fine = levels_.back();
    Level coarse;
    // A last odd texel has no partner and is left to the clamped edge.
    coarse.columns = fine.columns / 2;
    coarse.rows = fine.rows / 2;
    coarse.texels_per_metre = fine.texels_per_metre * 0.5F;
    coarse.texels.resize(static_cast<std::size_t>(coarse.columns) * coarse.rows);
    for (int row = 0; row < coarse.rows; ++row) {
      const uint8_t* top = &fine.texels[static_cast<std::size_t>(2 * row) * fine.columns];
      const uint8_t* bottom = top + fine.columns;
      uint8_t* texels = &coarse.texels[static_cast<std::size_t>(row) * coarse.columns];
      for (int column = 0; column < coarse.columns; ++column) {
        const int sum =
            top[2 * column] + top[2 * column + 1] + bottom[2 * column] + bottom[2 * column + 1];
        texels[column] = static_cast<uint8_t>((sum + 2) / 4);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

float Texture::Bilinear(const Level& level, float u, float v) {
  const float x =
      std::clamp(u * level.texels_per_metre - 0.5F, 0.0F, static_cast<float>(level.columns - 1));
  const float y =
      std::clamp(v * level.texels_per_metre - 0.5F, 0.0F, static_cast<float>(level.rows - 1));
  const int column = std::min(static_cast<int>(x), std::max(0, level.columns - 2));
  const int row = std::min(static_cast<int>(y), std::max(0, level.rows - 2));
  const int right = level.columns > 1 ? 1 : 0;
  const int down = level.rows > 1 ? level.columns : 0;
  const float a = x - static_cast<float>(column);
  const float b = y - static_cast<float>(row);
  const uint8_t* texel = &level.texels[static_cast<std::size_t>(row) * level.columns + column];
  const float top =
      static_cast<float>(texel[0]) * (1.0F - a) + static_cast<float>(texel[right]) * a;
  const float bottom =
      static_cast<float>(texel[down]) * (1.0F - a) + static_cast<float>(texel[down + right]) * a;
  return top * (1.0F - b) + bottom * b;
}

float Texture::Sample(double u, double v, double footprint_m) const {
  const float uf = static_cast<float>(u);
  const float vf = static_cast<float>(v);
  const float level = std::clamp(std::log2(static_cast<float>(footprint_m) / texel_m_), 0.0F,
                                 static_cast<float>(levels_.size() - 1));
  const int fine = static_cast<int>(level);
  const float part = level - static_cast<float>(fine);
  const float value = Bilinear(levels_[fine], uf, vf);
  if (part == 0.0F) return value;
  return value * (1.0F - part) + Bilinear(levels_[fine + 1], uf, vf) * part;
}

}  // namespace gluevo::vo
