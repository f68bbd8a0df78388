#include "safetensors_header.h"

#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/tensor.h"

namespace gluevo::nn {
namespace {

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

  std::vector<SafetensorsEntry> TakeEntries() { return std::move(entries_); }
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
    } else if (state_ == State::kTop && field_ == kSafetensorsMetadata) {
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
    file_.Fail(kSafetensorsLengthSize + (position > 0 ? position - 1 : 0),
               "the header is not valid JSON");
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
    return kSafetensorsLengthSize + static_cast<uint64_t>(quote - begin_);
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
  uint64_t at_ = kSafetensorsLengthSize;  // Offset of the latest key.
  std::string field_;                     // The latest key.
  std::vector<uint64_t>* numbers_ = nullptr;
  std::set<std::string> names_;
  std::set<std::string> fields_;
  std::vector<SafetensorsEntry> entries_;
  std::map<std::string, std::string> metadata_;
};

}  // namespace

SafetensorsHeader ReadSafetensorsHeader(const Bytes& file) {
  const uint64_t length = file.U64(0, "the header length");
  if (length > kLongestSafetensorsHeader) {
    file.Fail(0, "a header of " + std::to_string(length) + " bytes, at most " +
                     std::to_string(kLongestSafetensorsHeader) + " are allowed");
  }
  const Bytes header = file.Slice(kSafetensorsLengthSize, length, "the header");
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
  return {handler.TakeEntries(), handler.TakeMetadata(), kSafetensorsLengthSize + length};
}

}  // namespace gluevo::nn
