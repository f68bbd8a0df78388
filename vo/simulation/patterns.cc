#include "patterns.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "noise.h"
#include "random.h"

namespace gluevo::simulation {

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
