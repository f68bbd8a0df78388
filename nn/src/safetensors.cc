#include "safetensors.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "gluevo/nn/elements.h"
#include "safetensors_header.h"

namespace gluevo::nn {
namespace {

Shape ReadShape(const Bytes& file, const SafetensorsEntry& entry) {
  std::vector<int64_t> extents;
  for (const uint64_t extent : entry.shape) {
    constexpr uint64_t kLargest = std::numeric_limits<int64_t>::max();
    extents.push_back(static_cast<int64_t>(std::min(extent, kLargest)));
  }
  try {
    return Shape(extents.data(), extents.size());
  } catch (const Error& error) {
    file.Fail(entry.at, "tensor " + Quoted(entry.name) + ": " + error.what());
  }
}

std::size_t EntryElementSize(const Bytes& file, const SafetensorsEntry& entry, ElementType* type) {
  if (entry.dtype == "I64" && IsTrainingCounter(entry.name)) {
    return sizeof(int64_t);
  }
  if (entry.dtype == "F32") {
    *type = ElementType::kF32;
  } else if (entry.dtype == "F16") {
    *type = ElementType::kF16;
  } else if (entry.dtype == "BF16") {
    *type = ElementType::kBF16;
  } else if (entry.dtype == "F64") {
    *type = ElementType::kF64;
  } else {
    file.Fail(entry.at, "tensor " + Quoted(entry.name) + " has element type " +
                            Quoted(entry.dtype) + ", expected F32, F16, BF16 or F64");
  }
  return ElementSize(*type);
}

void CheckCoverage(const Bytes& file, uint64_t data_start, std::vector<SafetensorsEntry> entries) {
  std::sort(entries.begin(), entries.end(),
            [](const SafetensorsEntry& a, const SafetensorsEntry& b) {
              return a.data_offsets < b.data_offsets;
            });
  uint64_t covered = 0;
  for (const SafetensorsEntry& entry : entries) {
    const uint64_t begin = entry.data_offsets[0];
    if (begin < covered) {
      file.Fail(data_start + begin,
                "the data of tensor " + Quoted(entry.name) + " overlaps that of another");
    }
    if (begin > covered) {
      file.Fail(data_start + covered, std::to_string(begin - covered) +
                                          " bytes before the data of tensor " + Quoted(entry.name) +
                                          " belong to no tensor");
    }
    covered = entry.data_offsets[1];
  }
  if (data_start + covered != file.size()) {
    file.Fail(data_start + covered, std::to_string(file.size() - data_start - covered) +
                                        " trailing bytes belong to no tensor");
  }
}

}  // namespace

bool LooksLikeSafetensors(const Bytes& file) {
  return file.size() > kSafetensorsLengthSize && file.U32(4, "the header length") == 0 &&
         file.data()[kSafetensorsLengthSize] == '{';
}

void ParseSafetensors(const Bytes& file, Weights& weights) {
  SafetensorsHeader header = ReadSafetensorsHeader(file);
  const std::vector<SafetensorsEntry>& entries = header.entries;
  weights.metadata = std::move(header.metadata);

  const uint64_t data_start = header.data_start;
  const uint64_t data_size = file.size() - data_start;
  struct Checked {
    const SafetensorsEntry* entry;
    Shape shape;
    ElementType type;
  };
  std::vector<Checked> checked;
  for (const SafetensorsEntry& entry : entries) {
    const uint64_t first = entry.data_offsets[0];
    const uint64_t last = entry.data_offsets[1];
    const std::string subject = "tensor " + Quoted(entry.name);
    if (first > last || last > data_size) {
      file.Fail(entry.at, subject + " has data_offsets [" + std::to_string(first) + ", " +
                              std::to_string(last) + "], expected rising ones within " +
                              std::to_string(data_size) + " bytes of data");
    }
    ElementType type = ElementType::kF32;
    const std::size_t width = EntryElementSize(file, entry, &type);
    const Shape shape = ReadShape(file, entry);
    const uint64_t needed = static_cast<uint64_t>(shape.size()) * width;
    if (last - first != needed) {
      file.Fail(entry.at, subject + " of shape " + shape.ToString() + " and type " + entry.dtype +
                              " has " + std::to_string(last - first) + " bytes, expected " +
                              std::to_string(needed));
    }
    checked.push_back({&entry, shape, type});
  }
  CheckCoverage(file, data_start, entries);
  for (const Checked& item : checked) {
    const SafetensorsEntry& entry = *item.entry;
    if (entry.dtype == "I64") {
      continue;
    }
    const Bytes bytes = file.Slice(data_start + entry.data_offsets[0],
                                   entry.data_offsets[1] - entry.data_offsets[0], entry.name);
    weights.tensors.emplace(entry.name, ReadElements(bytes, item.type, item.shape, entry.name));
  }
}

}  // namespace gluevo::nn
