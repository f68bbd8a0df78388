#include "gluevo/nn/npy.h"

#include <cstring>
#include <set>
#include <string_view>
#include <vector>

#include "gluevo/nn/elements.h"

namespace gluevo::nn {
namespace {

constexpr std::string_view kMagic = "\x93NUMPY";

struct NpyHeader {
  std::string descr;
  bool fortran_order = false;
  std::vector<int64_t> shape;
};

/// Parses the Python dictionary of a .npy header, and nothing else that Python could say.
class NpyHeaderParser {
 public:
  NpyHeaderParser(const Bytes& text, const std::string& name) : text_(text), name_(name) {}

  NpyHeader Parse() {
    NpyHeader header;
    std::set<std::string> keys;
    Expect('{');
    while (!Accept('}')) {
      const uint64_t at = position_;
      const std::string key = ParseString("a key");
      if (!keys.insert(key).second) {
        Fail(at, "the key " + Quoted(key) + " comes twice");
      }
      Expect(':');
      if (key == "descr") {
        header.descr = ParseString("an element type");
      } else if (key == "fortran_order") {
        header.fortran_order = ParseBoolean();
      } else if (key == "shape") {
        header.shape = ParseShape();
      } else {
        Fail(at, "an unknown key " + Quoted(key));
      }
      if (!Accept(',')) {
        Expect('}');
        break;
      }
    }
    SkipBlanks();
    if (position_ != text_.size()) {
      Fail(position_, "text after the dictionary");
    }
    for (const char* key : {"descr", "fortran_order", "shape"}) {
      if (!keys.contains(key)) {
        Fail(0, std::string("no key \"") + key + "\"");
      }
    }
    return header;
  }

 private:
  [[noreturn]] void Fail(uint64_t at, const std::string& what) const {
    text_.Fail(at, "the header of array " + Quoted(name_) + " has " + what);
  }

  char Peek() const {
    return position_ < text_.size() ? static_cast<char>(text_.data()[position_]) : '\0';
  }
  void SkipBlanks() {
    while (Peek() == ' ' || Peek() == '\n') {
      ++position_;
    }
  }
  bool Accept(char wanted) {
    SkipBlanks();
    if (Peek() != wanted) {
      return false;
    }
    ++position_;
    return true;
  }
  void Expect(char wanted) {
    if (!Accept(wanted)) {
      Fail(position_, std::string("no '") + wanted + "' here");
    }
  }

  std::string ParseString(const std::string& what) {
    SkipBlanks();
    const uint64_t start = position_;
    const char quote = Peek();
    if (quote != '\'' && quote != '"') {
      Fail(start, "no string here, expected " + what);
    }
    std::string value;
    for (++position_; Peek() != quote; ++position_) {
      if (position_ >= text_.size() || Peek() == '\\' || Peek() == '\n') {
        Fail(start, "a broken string");
      }
      value += Peek();
    }
    ++position_;
    return value;
  }

  bool ParseBoolean() {
    SkipBlanks();
    const std::string_view rest(reinterpret_cast<const char*>(text_.data()) + position_,
                                text_.size() - position_);
    for (const bool value : {false, true}) {
      const std::string_view word = value ? "True" : "False";
      if (rest.starts_with(word)) {
        position_ += word.size();
        return value;
      }
    }
    Fail(position_, "neither True nor False here");
  }

  std::vector<int64_t> ParseShape() {
    std::vector<int64_t> shape;
    Expect('(');
    bool comma = true;
    while (!Accept(')')) {
      if (!comma) {
        Fail(position_, "no ',' here");
      }
      shape.push_back(ParseExtent());
      comma = Accept(',');
    }
    // (5) is a number in Python, not a tuple.
    if (shape.size() == 1 && !comma) {
      Fail(position_ - 1, "no ',' here");
    }
    return shape;
  }

  int64_t ParseExtent() {
    SkipBlanks();
    const uint64_t start = position_;
    int64_t value = 0;
    while (Peek() >= '0' && Peek() <= '9') {
      constexpr int64_t kLargest = int64_t{1} << 58;
      if (value > kLargest) {
        Fail(start, "an extent that overflows");
      }
      value = value * 10 + (Peek() - '0');
      ++position_;
    }
    if (position_ == start) {
      Fail(start, "no number here");
    }
    return value;
  }

  const Bytes& text_;
  const std::string& name_;
  uint64_t position_ = 0;
};

/// What the header says, checked against the size of the file.
struct Npy {
  std::optional<ElementType> type;  // None for a counter.
  Shape shape;
  bool fortran_order = false;
  Bytes data;
};

std::optional<ElementType> TypeOf(const std::string& descr) {
  if (descr == "<f4") {
    return ElementType::kF32;
  }
  if (descr == "<f2") {
    return ElementType::kF16;
  }
  if (descr == "<V2") {
    return ElementType::kBF16;
  }
  if (descr == "<f8") {
    return ElementType::kF64;
  }
  return std::nullopt;
}

Npy TakeApart(const Bytes& file, const std::string& name) {
  const std::string what = "array " + Quoted(name);
  const Bytes magic = file.Slice(0, kMagic.size() + 2, what);
  if (!LooksLikeNpy(file)) {
    file.Fail(0, what + " does not begin as a .npy file");
  }
  const int major = magic.data()[kMagic.size()];
  const int minor = magic.data()[kMagic.size() + 1];
  if (major < 1 || major > 3 || minor != 0) {
    file.Fail(kMagic.size(), what + " has .npy format " + std::to_string(major) + "." +
                                 std::to_string(minor) + ", expected 1.0 to 3.0");
  }
  const uint64_t length_at = magic.size();
  const uint64_t length_size = major == 1 ? 2 : 4;
  const uint64_t length =
      major == 1 ? file.U16(length_at, what) : uint64_t{file.U32(length_at, what)};
  const uint64_t text_at = length_at + length_size;
  const Bytes text = file.Slice(text_at, length, "the header of " + what);
  const NpyHeader header = NpyHeaderParser(text, name).Parse();

  const std::optional<ElementType> type = TypeOf(header.descr);
  if (!type && !(header.descr == "<i8" && IsTrainingCounter(name))) {
    const bool big_endian = header.descr.starts_with('>');
    text.Fail(0, what + " has element type " + Quoted(header.descr) +
                     (big_endian ? " (big-endian)" : "") +
                     ", expected '<f4', '<f2', '<f8' or bfloat16's '<V2'");
  }
  const std::size_t width = type ? ElementSize(*type) : sizeof(int64_t);
  Shape shape;
  try {
    shape = Shape(header.shape.data(), header.shape.size());
  } catch (const Error& error) {
    text.Fail(0, what + ": " + error.what());
  }
  const uint64_t data_at = text_at + length;
  const uint64_t needed = static_cast<uint64_t>(shape.size()) * width;
  const Bytes data = file.Slice(data_at, needed, what);
  if (file.size() - data_at != needed) {
    file.Fail(data_at + needed,
              what + " has " + std::to_string(file.size() - data_at - needed) + " trailing bytes");
  }
  return {type, shape, header.fortran_order, data};
}

}  // namespace

bool LooksLikeNpy(const Bytes& file) {
  return file.size() >= kMagic.size() &&
         std::memcmp(file.data(), kMagic.data(), kMagic.size()) == 0;
}

std::optional<Tensor<float>> ParseNpy(const Bytes& file, const std::string& name) {
  const Npy npy = TakeApart(file, name);
  if (!npy.type) {
    return std::nullopt;
  }
  Strides strides = RowMajorStrides(npy.shape);
  if (npy.fortran_order) {
    int64_t stride = 1;
    for (int axis = 0; axis < npy.shape.rank(); ++axis) {
      strides[axis] = stride;
      stride *= npy.shape[axis];
    }
  }
  return ReadStrided(npy.data, *npy.type, npy.shape, strides, 0, name);
}

}  // namespace gluevo::nn
