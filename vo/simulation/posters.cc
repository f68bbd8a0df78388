#include "patterns.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "noise.h"
#include "random.h"

namespace gluevo::simulation {
namespace {

/// One letter-like figure in the unit square: strokes on a grid of 5 x 7, often symmetric.
bool GlyphInk(double x, double y, uint64_t seed) {
  const int column = static_cast<int>(x * 6.0);
  const int row = static_cast<int>(y * 9.0) - 1;
  if (column > 4 || row < 0 || row > 6) return false;
  const auto bit = [seed](int i) { return ((seed >> i) & 1U) != 0; };
  const int key_column = bit(0) && column > 2 ? 4 - column : column;
  const bool stem = key_column == 0 && (bit(1) || bit(2));
  const bool bar = (row == 0 && bit(3)) || (row == 3 && bit(4)) || (row == 6 && bit(5));
  return stem || bar || CellUnit(key_column, row, seed) < 0.3;
}

/// Lines of words; the top of the page has larger letters.
Pattern GlyphPage(double width, double height, uint64_t seed) {
  RandomStream random(seed);
  const double paper = random.Uniform(0.75, 0.95);
  const double ink = random.Uniform(0.05, 0.2);
  const double title_share = random.Uniform(0.25, 0.6);
  const double title_line = height * title_share / (1 + random.Index(2));
  const double text_line = std::max(0.035, height * (1.0 - title_share) / (4 + random.Index(5)));
  return [=](double u, double v) {
    const double margin = 0.05 * std::min(width, height);
    if (u < margin || u > width - margin || v < margin || v > height - margin) return paper;
    const double down = height - v;
    const bool title = down < height * title_share;
    const double line = title ? title_line : text_line;
    const double y = title ? down / line : (down - height * title_share) / line;
    const double advance = 0.62 * line;
    const double x = u / advance;
    const uint32_t place = CellHash(Floor(x), Floor(y), Part(seed, title ? 1 : 2));
    if (place % 32 < 5) return paper;
    return GlyphInk(Fraction(x), Fraction(y), Hash(place)) ? ink : paper;
  };
}

/// Cells of random grays, black and white among them.
Pattern CellGrid(double width, double height, uint64_t seed) {
  RandomStream random(seed);
  const int columns = 5 + random.Index(8);
  const double cell = std::max(0.04, std::min(width, height) / columns);
  const bool binary = random.Index(2) == 0;
  return [=](double u, double v) {
    const double value = CellUnit(Floor(u / cell), Floor(v / cell), seed);
    return binary ? (value < 0.5 ? 0.07 : 0.92) : 0.05 + 0.9 * value;
  };
}

/// Rectangles and discs over each other, as on a poster.
Pattern Collage(double width, double height, uint64_t seed) {
  struct Piece {
    double u, v, half_width, half_height, cosine, sine, gray;
    bool disc;
  };
  RandomStream random(seed);
  std::vector<Piece> pieces;
  const double size = std::min(width, height);
  for (int i = 0; i < 26; ++i) {
    const double angle = random.Uniform(0.0, 3.14);
    const double scale = size * (i < 8 ? 0.35 : 0.14);
    pieces.push_back({random.Uniform(0.0, width), random.Uniform(0.0, height),
                      scale * random.Uniform(0.2, 1.0), scale * random.Uniform(0.2, 1.0),
                      std::cos(angle), std::sin(angle), random.Uniform(0.03, 0.97),
                      random.Index(4) == 0});
  }
  const double paper = random.Uniform(0.3, 0.9);
  return [=](double u, double v) {
    double gray = paper;
    for (const Piece& piece : pieces) {
      const double du = u - piece.u;
      const double dv = v - piece.v;
      const double x = (piece.cosine * du + piece.sine * dv) / piece.half_width;
      const double y = (piece.cosine * dv - piece.sine * du) / piece.half_height;
      const bool inside =
          piece.disc ? x * x + y * y < 1.0 : std::max(std::abs(x), std::abs(y)) < 1.0;
      gray = inside ? piece.gray : gray;
    }
    return gray;
  };
}

/// Squares cut into triangles of random grays.
Pattern Triangles(double width, double height, uint64_t seed) {
  RandomStream random(seed);
  const double cell = std::max(0.06, std::min(width, height) / (3 + random.Index(5)));
  return [=](double u, double v) {
    const int64_t column = Floor(u / cell);
    const int64_t row = Floor(v / cell);
    const double x = Fraction(u / cell);
    const double y = Fraction(v / cell);
    const bool falling = CellUnit(column, row, Part(seed, 1)) < 0.5;
    const bool upper = falling ? y > 1.0 - x : y > x;
    return 0.05 + 0.9 * CellUnit(column, row, Part(seed, upper ? 2 : 3));
  };
}

}  // namespace

Pattern Poster(double width_m, double height_m, uint64_t seed) {
  switch (Hash(seed, 0x706F73746572ULL) % 5) {
    case 0:
    case 1:
      return GlyphPage(width_m, height_m, seed);
    case 2:
      return CellGrid(width_m, height_m, seed);
    case 3:
      return Collage(width_m, height_m, seed);
    default:
      return Triangles(width_m, height_m, seed);
  }
}

Pattern WithPosters(Pattern background, double width_m, double height_m, int count, uint64_t seed) {
  struct Sheet {
    double u, v, width, height;
    Pattern print;
  };
  RandomStream random(seed);
  std::vector<Sheet> sheets;
  constexpr double kGap = 0.04;
  for (int attempt = 0; attempt < 20 * count && static_cast<int>(sheets.size()) < count;
       ++attempt) {
    const double sheet_width = std::min(random.Uniform(0.3, 1.3), 0.8 * width_m);
    const double sheet_height = std::min(random.Uniform(0.3, 1.1), 0.8 * height_m);
    const double u = random.Uniform(0.0, width_m - sheet_width);
    const double v = random.Uniform(0.0, height_m - sheet_height);
    const bool free = std::none_of(sheets.begin(), sheets.end(), [&](const Sheet& other) {
      return u < other.u + other.width + kGap && other.u < u + sheet_width + kGap &&
             v < other.v + other.height + kGap && other.v < v + sheet_height + kGap;
    });
    const uint64_t sheet_seed = random.Next();
    if (free) {
      sheets.push_back(
          {u, v, sheet_width, sheet_height, Poster(sheet_width, sheet_height, sheet_seed)});
    }
  }
  // The sheets that touch each cell of a grid, so that a texel need not ask all of them.
  constexpr double kCell = 0.25;
  const int columns = static_cast<int>(width_m / kCell) + 1;
  const int rows = static_cast<int>(height_m / kCell) + 1;
  std::vector<std::vector<int>> cells(static_cast<std::size_t>(columns) * rows);
  for (int i = 0; i < static_cast<int>(sheets.size()); ++i) {
    const Sheet& sheet = sheets[i];
    const int last_row = std::min(rows - 1, static_cast<int>((sheet.v + sheet.height) / kCell));
    const int last = std::min(columns - 1, static_cast<int>((sheet.u + sheet.width) / kCell));
    for (int row = static_cast<int>(sheet.v / kCell); row <= last_row; ++row) {
      for (int column = static_cast<int>(sheet.u / kCell); column <= last; ++column) {
        cells[static_cast<std::size_t>(row) * columns + column].push_back(i);
      }
    }
  }
  return [=, background = std::move(background), sheets = std::move(sheets),
          cells = std::move(cells)](double u, double v) {
    const int column = std::clamp(static_cast<int>(u / kCell), 0, columns - 1);
    const int row = std::clamp(static_cast<int>(v / kCell), 0, rows - 1);
    for (const int i : cells[static_cast<std::size_t>(row) * columns + column]) {
      const Sheet& sheet = sheets[i];
      const double x = u - sheet.u;
      const double y = v - sheet.v;
      if (x >= 0.0 && x < sheet.width && y >= 0.0 && y < sheet.height) {
        return sheet.print(x, y) + 0.12 * (Noise(u, v, 0.2, 0.025, 0.8, Part(seed, 9)) - 0.5);
      }
    }
    return background(u, v);
  };
}

}  // namespace gluevo::simulation
