#pragma once

#include <array>
#include <cstdint>

namespace gluevo::simulation {

/// A well-mixed hash of a counter (the finaliser of SplitMix64, Steele et al. 2014): randomness
/// that does not depend on the order in which it is drawn.
constexpr uint64_t Hash(uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31);
}

template <typename... Rest>
constexpr uint64_t Hash(uint64_t first, uint64_t second, Rest... rest) {
  return Hash(Hash(first) ^ second, static_cast<uint64_t>(rest)...);
}

/// The upper 53 bits of a hash as a number in [0, 1).
constexpr double Unit(uint64_t hash) { return static_cast<double>(hash >> 11) * 0x1p-53; }

/// Independent draws in a fixed order.
class RandomStream {
 public:
  explicit RandomStream(uint64_t seed) : seed_(seed) {}
  uint64_t Next() { return Hash(seed_, count_++); }
  double Uniform(double low, double high) { return low + (high - low) * Unit(Next()); }
  /// 0 .. count - 1
  int Index(int count) { return static_cast<int>(Next() % static_cast<uint64_t>(count)); }

 private:
  uint64_t seed_;
  uint64_t count_ = 0;
};

/// The standard normal distribution by its inverse at 4096 equally probable steps, so that a draw
/// is one look-up. Its values have mean 0, lie within 3.7 and vary by 1 to within 0.1 %.
class NormalTable {
 public:
  static constexpr int kBits = 12;
  NormalTable();
  float operator()(uint64_t hash) const { return values_[hash >> (64 - kBits)]; }

 private:
  std::array<float, 1 << kBits> values_ = {};
};

}  // namespace gluevo::simulation
