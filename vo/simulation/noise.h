#pragma once

#include <cmath>
#include <cstdint>

namespace gluevo::simulation {

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

inline uint32_t CellHash(int64_t column, int64_t row, uint64_t seed) {
  return Finish((static_cast<uint32_t>(column) * kColumnStep) ^
                (static_cast<uint32_t>(row) * kRowStep + Fold(seed)));
}

/// Draw of [0, 1) that belongs to a cell of a grid.
inline double CellUnit(int64_t column, int64_t row, uint64_t seed) {
  return CellHash(column, row, seed) * 0x1p-32;
}

inline int64_t Floor(double value) {
  const auto whole = static_cast<int64_t>(value);
  return whole - (static_cast<double>(whole) > value ? 1 : 0);
}
inline double Fraction(double value) { return value - static_cast<double>(Floor(value)); }

/// Smooth noise of one wavelength, 1: 0 to 1.
float ValueNoise(double x, double y, uint64_t seed);

/// Smooth noise of several octaves, mean about 0.5: wavelengths from `coarsest_m` halving down to
/// `finest_m`, each weighing `persistence` times the one before.
double Noise(double u, double v, double coarsest_m, double finest_m, double persistence,
             uint64_t seed);

}  // namespace gluevo::simulation
