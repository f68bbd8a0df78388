#include "patterns.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "random.h"

namespace gluevo::simulation {
namespace {

/// The seed of a part of a pattern: cheap, since the hashes of cells mix it.
constexpr uint64_t Part(uint64_t seed, uint64_t part) {
  return seed + part * 0x9E3779B97F4A7C15ULL;
}

/// A 32-bit hash of a cell of a grid (finaliser: Wellons, "Prospecting for hash functions", 2018):
/// millions of texels need several each.
constexpr uint32_t kColumnStep = 0x9E3779B1U;
constexpr uint32_t kRowStep = 0x85EBCA77U;

constexpr uint32_t Fold(uint64_t seed) { return static_cast<uint32_t>(seed ^ (seed >> 32)); }

constexpr uint32_t Finish(uint32_t hash) {
  hash = (hash ^ (hash >> 16)) * 0x7FEB352DU;
  hash = (hash ^ (hash >> 15)) * 0x846CA68BU;
  return hash ^ (hash >> 16);
}

uint32_t CellHash(int64_t column, int64_t row, uint64_t seed) {
  return Finish((static_cast<uint32_t>(column) * kColumnStep) ^
                (static_cast<uint32_t>(row) * kRowStep + Fold(seed)));
}

/// Draw of [0, 1) that belongs to a cell of a grid.
double CellUnit(int64_t column, int64_t row, uint64_t seed) {
  return CellHash(column, row, seed) * 0x1p-32;
}

int64_t Floor(double value) {
  const auto whole = static_cast<int64_t>(value);
  return whole - (static_cast<double>(whole) > value ? 1 : 0);
}
double Fraction(double value) { return value - static_cast<double>(Floor(value)); }

/// Values of [0, 1) at the cells' corners, smoothly interpolated.
float ValueNoise(double x, double y, uint64_t seed) {
  const int64_t column = Floor(x);
  const int64_t row = Floor(y);
  const auto smooth = [](float t) { return t * t * (3.0F - 2.0F * t); };
  const float a = smooth(static_cast<float>(x - static_cast<double>(column)));
  const float b = smooth(static_cast<float>(y - static_cast<double>(row)));
  const uint32_t left = static_cast<uint32_t>(column) * kColumnStep;
  const uint32_t right = left + kColumnStep;
  const uint32_t below = static_cast<uint32_t>(row) * kRowStep + Fold(seed);
  const uint32_t above = below + kRowStep;
  const auto corner = [](uint32_t hash) {
    return static_cast<float>(static_cast<int32_t>(Finish(hash) >> 8)) * 0x1p-24F;
  };
  const float low = corner(left ^ below) * (1.0F - a) + corner(right ^ below) * a;
  const float high = corner(left ^ above) * (1.0F - a) + corner(right ^ above) * a;
  return low + (high - low) * b;
}

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

double Noise(double u, double v, double coarsest_m, double finest_m, double persistence,
             uint64_t seed) {
  double sum = 0.0;
  double weights = 0.0;
  double weight = 1.0;
  double frequency = 1.0 / coarsest_m;
  const double highest = 1.0 / finest_m;
  for (uint64_t octave = 0; frequency <= highest; ++octave, frequency *= 2.0) {
    sum += weight * ValueNoise(u * frequency, v * frequency, Part(seed, octave));
    weights += weight;
    weight *= persistence;
  }
  return weights > 0.0 ? sum / weights : 0.5;
}

Pattern Bricks(uint64_t seed) {
  return [seed](double u, double v) {
    constexpr double kLength = 0.26;
    constexpr double kHeight = 0.09;
    constexpr double kMortar = 0.012;
    const int64_t row = Floor(v / kHeight);
    const double shifted =
        u + kLength * (0.5 * static_cast<double>(row & 1) + 0.3 * CellUnit(0, row, Part(seed, 1)));
    const int64_t column = Floor(shifted / kLength);
    const double x = Fraction(shifted / kLength) * kLength;
    const double y = Fraction(v / kHeight) * kHeight;
    const double grain = Noise(u, v, 0.06, 0.012, 0.7, Part(seed, 2)) - 0.5;
    // Chipped corners and edges: the mortar's width wanders.
    const double mortar = kMortar * (0.5 + 1.4 * ValueNoise(u / 0.03, v / 0.03, Part(seed, 3)));
    if (x < mortar || y < mortar) return 0.62 + 0.3 * grain;
    const double gray = CellUnit(column, row, Part(seed, 4));
    return 0.18 + 0.5 * gray * gray + 0.35 * grain;
  };
}

Pattern Tiles(double tile_m, uint64_t seed) {
  return [tile_m, seed](double u, double v) {
    const int64_t column = Floor(u / tile_m);
    const int64_t row = Floor(v / tile_m);
    const double x = Fraction(u / tile_m);
    const double y = Fraction(v / tile_m);
    const double grain = Noise(u, v, 0.4, 0.012, 0.75, Part(seed, 1)) - 0.5;
    const double gap = 0.006 / tile_m;
    if (x < gap || y < gap) return 0.15 + 0.2 * grain;
    const double kind = CellUnit(column, row, Part(seed, 2));
    double gray = 0.2 + 0.55 * CellUnit(column, row, Part(seed, 3));
    if (kind < 0.35) {
      const int parts = kind < 0.12 ? 2 : (kind < 0.24 ? 3 : 4);
      const int64_t sub_column = column * parts + static_cast<int64_t>(x * parts);
      const int64_t sub_row = row * parts + static_cast<int64_t>(y * parts);
      const bool board = kind > 0.18;
      const double own = CellUnit(sub_column, sub_row, Part(seed, 4));
      gray = board ? (((sub_column + sub_row) & 1) != 0 ? 0.8 - 0.2 * own : 0.1 + 0.2 * own)
                   : 0.1 + 0.8 * own;
    }
    return gray + 0.3 * grain;
  };
}

Pattern Planks(uint64_t seed) {
  return [seed](double u, double v) {
    constexpr double kWidth = 0.13;
    constexpr double kLength = 0.9;
    const int64_t row = Floor(v / kWidth);
    const double shifted = u / kLength + 7.0 * CellUnit(0, row, Part(seed, 1));
    const int64_t column = Floor(shifted);
    const double x = Fraction(shifted) * kLength;
    const double y = Fraction(v / kWidth) * kWidth;
    if (x < 0.006 || y < 0.006) return 0.08;
    const double own = CellUnit(column, row, Part(seed, 2));
    const double grain = Noise(u * 0.12 + 50.0 * own, v, 0.04, 0.006, 0.8, Part(seed, 3)) - 0.5;
    // Knots: about one a plank.
    const double knot_x = kLength * CellUnit(column, row, Part(seed, 4));
    const double knot_y = kWidth * (0.2 + 0.6 * CellUnit(column, row, Part(seed, 5)));
    const double distance = std::hypot((x - knot_x) * 0.7, y - knot_y);
    const double knot = distance < 0.016 ? -0.25 : 0.0;
    return 0.3 + 0.35 * own + 0.45 * grain + knot;
  };
}

Pattern CeilingPanels(uint64_t seed) {
  return [seed](double u, double v) {
    constexpr double kPanel = 0.6;
    constexpr double kHole = 0.05;
    const double x = Fraction(u / kPanel) * kPanel;
    const double y = Fraction(v / kPanel) * kPanel;
    const double grain = Noise(u, v, 0.8, 0.025, 0.7, Part(seed, 1)) - 0.5;
    if (x < 0.02 || y < 0.02) return 0.3 + 0.2 * grain;
    const int64_t column = Floor(u / kHole);
    const int64_t row = Floor(v / kHole);
    const double own = CellUnit(Floor(u / kPanel), Floor(v / kPanel), Part(seed, 2));
    const double density = 0.15 + 0.25 * own;
    double gray = 0.55 + 0.25 * own + 0.3 * grain;
    if (CellUnit(column, row, Part(seed, 3)) < density) {
      const double du = Fraction(u / kHole) - 0.3 - 0.4 * CellUnit(column, row, Part(seed, 4));
      const double dv = Fraction(v / kHole) - 0.3 - 0.4 * CellUnit(column, row, Part(seed, 5));
      const double radius = 0.12 + 0.16 * CellUnit(column, row, Part(seed, 6));
      gray = std::max(std::abs(du), std::abs(dv)) < radius ? 0.2 : gray;
    }
    return gray;
  };
}

Pattern Blotches(double size_m, uint64_t seed) {
  return [size_m, seed](double u, double v) {
    const double shape = Noise(u, v, size_m, size_m / 9.0, 0.65, Part(seed, 1));
    const double grain = Noise(u, v, 0.05, 0.012, 0.8, Part(seed, 2)) - 0.5;
    const double gray = shape < 0.42 ? 0.15 : (shape < 0.5 ? 0.4 : (shape < 0.58 ? 0.62 : 0.85));
    return gray + 0.25 * grain;
  };
}

Pattern Plaster(uint64_t seed) {
  return [seed](double u, double v) {
    const double broad = Noise(u, v, 1.2, 0.1, 0.6, Part(seed, 1)) - 0.5;
    const double grain = Noise(u, v, 0.05, 0.012, 0.9, Part(seed, 2)) - 0.5;
    const double stain = Noise(u, v, 0.25, 0.03, 0.6, Part(seed, 3));
    return 0.62 + 0.35 * broad + 0.25 * grain - (stain > 0.68 ? 0.22 : 0.0);
  };
}

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

Pattern Mirrored(Pattern pattern, double period_u_m, double period_v_m) {
  const auto fold = [](double value, double period) {
    const double x = 2.0 * Fraction(0.5 * value / period);
    return period * (x < 1.0 ? x : 2.0 - x);
  };
  return [=, pattern = std::move(pattern)](double u, double v) {
    return pattern(fold(u, period_u_m), fold(v, period_v_m));
  };
}

}  // namespace gluevo::simulation
