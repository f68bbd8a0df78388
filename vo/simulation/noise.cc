#include "noise.h"

#include <cmath>

namespace gluevo::simulation {
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

}  // namespace gluevo::simulation
