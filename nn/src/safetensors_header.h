#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gluevo/nn/bytes.h"

namespace gluevo::nn {

/// Before the header lies its length.
inline constexpr uint64_t kSafetensorsLengthSize = 8;
/// What the format's own reader allows, bytes.
inline constexpr uint64_t kLongestSafetensorsHeader = 100'000'000;
/// The entry that is no tensor.
inline constexpr const char* kSafetensorsMetadata = "__metadata__";

/// A tensor as the header describes it, not checked against the data.
struct SafetensorsEntry {
  std::string name;
  uint64_t at = 0;  ///< Offset of its name in the file.
  std::string dtype;
  std::vector<uint64_t> shape;
  std::vector<uint64_t> data_offsets;
};

struct SafetensorsHeader {
  std::vector<SafetensorsEntry> entries;
  std::map<std::string, std::string> metadata;
  uint64_t data_start = 0;  ///< Offset in the file of the data.
};

/// Reads the length and the JSON of a file's header. Throws Error with the offset for anything that
/// the format does not allow, and for names and fields that come twice.
SafetensorsHeader ReadSafetensorsHeader(const Bytes& file);

}  // namespace gluevo::nn
