#include "safetensors.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "gluevo/nn/elements.h"
#include "gluevo/nn/output_file.h"

namespace gluevo::nn {
namespace {

constexpr uint64_t kLengthSize = 8;
// What the format's own reader allows.
constexpr uint64_t kLongestHeader = 100'000'000;
constexpr const char* kMetadataName = "__metadata__";

struct Entry {
  std::string name;
  uint64_t at = 0;  // Offset of its name in the file.
  std::string dtype;
  std::vector<uint64_t> shape;
  std::vector<uint64_t> data_offsets;
};

/// Feeds the JSON parser and counts what it has taken, as the parser does not tell its handler.
class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* position, const char** reached)
      : position_(position), reached_(reached) {}
  reference operator*() const { return *position_; }
  CountingIterator& operator++() {
    *reached_ = ++position_;
    return *this;
  }
  CountingIterator operator++(int) {
    CountingIterator before = *this;
    ++*this;
    return before;
  }
  friend bool operator==(const CountingIterator& a, const CountingIterator& b) {
    return a.position_ == b.position_;
  }

 private:
  const char* position_;
  const char** reached_;
};

/// Takes the header's JSON event by event: a tree would hide names that come twice.
class HeaderHandler final : public nlohmann::json_sax<nlohmann::json> {
 public:
  HeaderHandler(const Bytes& file, const char* begin, const char* const* reached)
      : file_(file), begin_(begin), reached_(reached) {}

  std::vector<Entry> TakeEntries() { return std::move(entries_); }
  std::map<std::string, std::string> TakeMetadata() { return std::move(metadata_); }

  bool null() override { Unexpected("null"); }
  bool boolean(bool /*value*/) override { Unexpected("a boolean"); }
  bool number_integer(number_integer_t /*value*/) override { Unexpected("a negative number"); }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override {
    Unexpected("a number that is no 64-bit integer");
  }
  bool binary(binary_t& /*value*/) override { Unexpected("binary data"); }

  bool number_unsigned(number_unsigned_t value) override {
    if (state_ != State::kNumbers) {
      Unexpected("a number");
    }
    const std::size_t most = field_ == "shape" ? Shape::kMaxRank : 2;
    if (numbers_->size() == most) {
      Fail(Subject() + ": \"" + field_ + "\" has more than " + std::to_string(most) + " numbers");
    }
    numbers_->push_back(value);
    return true;
  }

  bool string(string_t& value) override {
    if (state_ == State::kMetadata) {
      metadata_[field_] = value;
    } else if (state_ == State::kEntry && field_ == "dtype") {
      entries_.back().dtype = value;
    } else {
      Unexpected("a string");
    }
    return true;
  }

  bool start_object(std::size_t /*count*/) override {
    if (state_ == State::kStart) {
      state_ = State::kTop;
    } else if (state_ == State::kTop && field_ == kMetadataName) {
      state_ = State::kMetadata;
    } else if (state_ == State::kTop) {
      state_ = State::kEntry;
      entries_.emplace_back();
      entries_.back().name = field_;
      entries_.back().at = at_;
    } else {
      Unexpected("an object");
    }
    fields_.clear();
    return true;
  }

  bool key(string_t& name) override {
    at_ = KeyOffset();
    field_ = name;
    if (state_ == State::kTop) {
      if (!names_.insert(name).second) {
        Fail("the name " + Quoted(name) + " comes twice");
      }
      return true;
    }
    if (state_ == State::kEntry && name != "dtype" && name != "shape" && name != "data_offsets") {
      Fail(Subject() + " has an unknown field " + Quoted(name) +
           ", expected \"dtype\", \"shape\" and \"data_offsets\"");
    }
    if (!fields_.insert(name).second) {
      Fail(Subject() + ": the field " + Quoted(name) + " comes twice");
    }
    return true;
  }

  bool end_object() override {
    if (state_ == State::kEntry) {
      for (const char* field : {"dtype", "shape", "data_offsets"}) {
        if (!fields_.contains(field)) {
          at_ = entries_.back().at;
          Fail(Subject() + " has no \"" + field + "\"");
        }
      }
      if (entries_.back().data_offsets.size() != 2) {
        Fail(Subject() + ": \"data_offsets\" has " +
             std::to_string(entries_.back().data_offsets.size()) + " numbers, expected 2");
      }
    }
    state_ = state_ == State::kTop ? State::kStart : State::kTop;
    return true;
  }

  bool start_array(std::size_t /*count*/) override {
    if (state_ != State::kEntry || field_ == "dtype") {
      Unexpected("an array");
    }
    numbers_ = field_ == "shape" ? &entries_.back().shape : &entries_.back().data_offsets;
    state_ = State::kNumbers;
    return true;
  }

  bool end_array() override {
    state_ = State::kEntry;
    return true;
  }

  bool parse_error(std::size_t position, const std::string& /*token*/,
                   const nlohmann::json::exception& /*error*/) override {
    file_.Fail(kLengthSize + (position > 0 ? position - 1 : 0), "the header is not valid JSON");
  }

 private:
  enum class State { kStart, kTop, kMetadata, kEntry, kNumbers };

  // The parser has just taken the closing quote of a key. Inside it every quote has a backslash
  // before it, and outside no backslash is possible.
  uint64_t KeyOffset() const {
    const char* quote = *reached_ - 2;
    while (quote > begin_ && (*quote != '"' || quote[-1] == '\\')) {
      --quote;
    }
    return kLengthSize + static_cast<uint64_t>(quote - begin_);
  }

  std::string Subject() const {
    return state_ == State::kMetadata ? std::string("\"__metadata__\"")
                                      : "tensor " + Quoted(entries_.back().name);
  }

  [[noreturn]] void Fail(const std::string& message) const { file_.Fail(at_, message); }
  [[noreturn]] void Unexpected(const std::string& what) const {
    if (state_ == State::kStart) {
      Fail("the header is " + what + ", expected an object");
    }
    Fail("in the header " + Quoted(field_) + " holds " + what +
         ", which the format does not allow");
  }

  const Bytes& file_;
  const char* begin_;
  const char* const* reached_;
  State state_ = State::kStart;
  uint64_t at_ = kLengthSize;  // Offset of the latest key.
  std::string field_;          // The latest key.
  std::vector<uint64_t>* numbers_ = nullptr;
  std::set<std::string> names_;
  std::set<std::string> fields_;
  std::vector<Entry> entries_;
  std::map<std::string, std::string> metadata_;
};

Shape ReadShape(const Bytes& file, const Entry& entry) {
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

std::size_t EntryElementSize(const Bytes& file, const Entry& entry, ElementType* type) {
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

void CheckCoverage(const Bytes& file, uint64_t data_start, std::vector<Entry> entries) {
  std::sort(entries.begin(), entries.end(),
            [](const Entry& a, const Entry& b) { return a.data_offsets < b.data_offsets; });
  uint64_t covered = 0;
  for (const Entry& entry : entries) {
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
  return file.size() > kLengthSize && file.U32(4, "the header length") == 0 &&
         file.data()[kLengthSize] == '{';
}

void ParseSafetensors(const Bytes& file, Weights& weights) {
  const uint64_t length = file.U64(0, "the header length");
  if (length > kLongestHeader) {
    file.Fail(0, "a header of " + std::to_string(length) + " bytes, at most " +
                     std::to_string(kLongestHeader) + " are allowed");
  }
  const Bytes header = file.Slice(kLengthSize, length, "the header");
  const auto* begin = reinterpret_cast<const char*>(header.data());
  if (length == 0 || *begin != '{') {
    header.Fail(0, "the header does not begin with {");
  }
  // The JSON parser would take a zero byte for the end.
  if (const void* zero = std::memchr(begin, 0, length)) {
    header.Fail(static_cast<const char*>(zero) - begin, "the header holds a zero byte");
  }
  const char* reached = begin;
  HeaderHandler handler(file, begin, &reached);
  nlohmann::json::sax_parse(CountingIterator(begin, &reached),
                            CountingIterator(begin + length, &reached), &handler);
  const std::vector<Entry> entries = handler.TakeEntries();
  weights.metadata = handler.TakeMetadata();

  const uint64_t data_start = kLengthSize + length;
  const uint64_t data_size = file.size() - data_start;
  struct Checked {
    const Entry* entry;
    Shape shape;
    ElementType type;
  };
  std::vector<Checked> checked;
  for (const Entry& entry : entries) {
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
    const Entry& entry = *item.entry;
    if (entry.dtype == "I64") {
      continue;
    }
    const Bytes bytes = file.Slice(data_start + entry.data_offsets[0],
                                   entry.data_offsets[1] - entry.data_offsets[0], entry.name);
    weights.tensors.emplace(entry.name, ReadElements(bytes, item.type, item.shape, entry.name));
  }
}

void WriteSafetensors(const std::filesystem::path& path, const Weights& weights) {
  nlohmann::ordered_json header = nlohmann::ordered_json::object();
  if (!weights.metadata.empty()) {
    header[kMetadataName] = nlohmann::ordered_json::object();
    for (const auto& [name, text] : weights.metadata) {
      header[kMetadataName][name] = text;
    }
  }
  uint64_t offset = 0;
  for (const auto& [name, tensor] : weights.tensors) {
    if (name == kMetadataName) {
      throw Error(path.string() + ": a tensor cannot be named " + Quoted(name));
    }
    for (int64_t i = 0; i < tensor.size(); ++i) {
      if (!std::isfinite(tensor[i])) {
        throw Error(path.string() + ": tensor " + Quoted(name) + " holds " +
                    (std::isnan(tensor[i]) ? "NaN" : "an infinite value") +
                    ", expected finite weights");
      }
    }
    const uint64_t size = static_cast<uint64_t>(tensor.size()) * sizeof(float);
    nlohmann::ordered_json& entry = header[name];
    entry["dtype"] = "F32";
    entry["shape"] = nlohmann::ordered_json::array();
    for (int axis = 0; axis < tensor.shape().rank(); ++axis) {
      entry["shape"].push_back(tensor.extent(axis));
    }
    entry["data_offsets"] = {offset, offset + size};
    offset += size;
  }
  std::string text;
  try {
    text = header.dump();
  } catch (const nlohmann::json::exception&) {
    throw Error(path.string() + ": a name or a metadata text is not valid UTF-8");
  }
  while (text.size() % 8 != 0) {  // The data then begins at a multiple of eight.
    text += ' ';
  }
  if (text.size() > kLongestHeader) {
    throw Error(path.string() + ": a header of " + std::to_string(text.size()) +
                " bytes, at most " + std::to_string(kLongestHeader) + " are allowed");
  }
  WriteWholeFile(path, [&](std::ostream& stream) {
    const uint64_t length = text.size();
    stream.write(reinterpret_cast<const char*>(&length), sizeof(length));
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    for (const auto& [name, tensor] : weights.tensors) {
      stream.write(reinterpret_cast<const char*>(tensor.data()),
                   static_cast<std::streamsize>(tensor.size() * sizeof(float)));
    }
  });
}

}  // namespace gluevo::nn
