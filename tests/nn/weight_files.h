#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "gluevo/nn/weights.h"

// Weights files put together byte by byte, without the library's writer, and what every reader of
// hostile files has to show.

namespace gluevo::nn {

/// Little-endian bytes of a number.
template <typename T>
std::string Le(T value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    bytes += static_cast<char>(static_cast<uint64_t>(value) >> (8 * i));
  }
  return bytes;
}

inline std::string Floats(const std::vector<float>& values) {
  std::string bytes;
  for (const float value : values) {
    bytes += Le(std::bit_cast<uint32_t>(value));
  }
  return bytes;
}

inline std::vector<float> Values(const Tensor<float>& tensor) {
  return {tensor.data(), tensor.data() + tensor.size()};
}

inline Weights Parse(const std::string& bytes) {
  // A copy of exactly this size lets the address sanitiser see every byte read beyond it.
  const std::vector<char> copy(bytes.begin(), bytes.end());
  return ParseWeights(copy.data(), copy.size(), "file");
}

/// Expects an Error of one line that names this offset and says this.
inline void ExpectRefused(const std::string& bytes, const std::string& offset,
                          const std::string& phrase) {
  try {
    Parse(bytes);
    ADD_FAILURE() << "accepted, expected: " << phrase;
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(message.rfind("file: byte " + offset + ": ", 0), 0U) << message;
    EXPECT_NE(message.find(phrase), std::string::npos) << message << "\nexpected: " << phrase;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

inline void ExpectRefused(const std::string& bytes, uint64_t offset, const std::string& phrase) {
  ExpectRefused(bytes, std::to_string(offset), phrase);
}

/// Every beginning of a file but the whole is refused, by Error and nothing else.
inline void ExpectEveryTruncationRefused(const std::string& bytes) {
  ASSERT_NO_THROW(Parse(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(Parse(bytes.substr(0, size)), Error) << "cut to " << size << " bytes";
  }
}

/// A file with bytes changed is read or refused by Error, and nothing else happens.
inline void ExpectFlipsSurvived(const std::string& bytes, int rounds) {
  std::mt19937 random(20240517);
  int refused = 0;
  for (int round = 0; round < rounds; ++round) {
    std::string changed = bytes;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < flips; ++i) {
      changed[random() % changed.size()] = static_cast<char>(random());
    }
    try {
      Parse(changed);
    } catch (const Error& error) {
      ++refused;
      ASSERT_EQ(std::strchr(error.what(), '\n'), nullptr) << error.what();
    }
  }
  // Most bytes of these files are structure.
  EXPECT_GT(refused, rounds / 4);
}

}  // namespace gluevo::nn
