#include "texture.h"

#include <cmath>
#include <utility>

#include "parallel_for.h"

namespace gluevo::simulation {

Texture::Level::Level(int columns_in, int rows_in, double texel_m)
    : columns(columns_in),
      rows(rows_in),
      stride(columns_in + 1),
      last_column(static_cast<float>(columns_in - 1)),
      last_row(static_cast<float>(rows_in - 1)),
      texels_per_metre(static_cast<float>(1.0 / texel_m)),
      texels(static_cast<std::size_t>(stride) * (rows_in + 1)) {}

void Texture::Level::Pad() {
  for (int row = 0; row < rows; ++row) {
    uint8_t* const line = &texels[static_cast<std::size_t>(row) * stride];
    line[columns] = line[columns - 1];
  }
  const auto last = texels.end() - 2 * static_cast<std::ptrdiff_t>(stride);
  std::copy(last, last + stride, last + stride);
}

Texture::Texture() {
  Level gray(1, 1, 1.0);
  std::fill(gray.texels.begin(), gray.texels.end(), uint8_t{128});
  levels_ = std::make_shared<const std::vector<Level>>(1, std::move(gray));
}

Texture::Texture(double width_m, double height_m, double texel_m, const Pattern& pattern,
                 int threads, const std::function<void()>& checkpoint) {
  constexpr double kMostTexels = 16384.0;
  texel_m = std::max(texel_m, std::max(width_m, height_m) / kMostTexels);
  log2_texel_m_ = static_cast<float>(std::log2(texel_m));
  std::vector<Level> levels;
  levels.emplace_back(std::max(1, static_cast<int>(std::ceil(width_m / texel_m))),
                      std::max(1, static_cast<int>(std::ceil(height_m / texel_m))), texel_m);
  Level& base = levels.back();
  ParallelFor(base.rows, threads, [&](int row) {
    if (checkpoint) checkpoint();
    uint8_t* texels = &base.texels[static_cast<std::size_t>(row) * base.stride];
    for (int column = 0; column < base.columns; ++column) {
      const double value = pattern((column + 0.5) * texel_m, (row + 0.5) * texel_m);
      texels[column] = static_cast<uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
    }
  });
  base.Pad();
  while (levels.back().columns > 1 && levels.back().rows > 1) {
    const Level& fine = levels.back();
    // A last odd texel has no partner and is left to the clamped edge.
    texel_m *= 2.0;
    Level coarse(fine.columns / 2, fine.rows / 2, texel_m);
    for (int row = 0; row < coarse.rows; ++row) {
      const uint8_t* top = &fine.texels[static_cast<std::size_t>(2 * row) * fine.stride];
      const uint8_t* bottom = top + fine.stride;
      uint8_t* texels = &coarse.texels[static_cast<std::size_t>(row) * coarse.stride];
      for (int column = 0; column < coarse.columns; ++column) {
        const int sum =
            top[2 * column] + top[2 * column + 1] + bottom[2 * column] + bottom[2 * column + 1];
        texels[column] = static_cast<uint8_t>((sum + 2) / 4);
      }
    }
    coarse.Pad();
    levels.push_back(std::move(coarse));
  }
  levels_ = std::make_shared<const std::vector<Level>>(std::move(levels));
}

}  // namespace gluevo::simulation
