#include "protobuf.h"

namespace gluevo::weights_tools {
namespace {

using Type = ProtobufField::Type;

uint64_t ReadVarint(const nn::Bytes& bytes, uint64_t& at) {
  constexpr int kLongest = 10;
  uint64_t value = 0;
  for (int i = 0; i < kLongest; ++i) {
    const uint8_t byte = *bytes.Slice(at, 1, "a number").data();
    if (i == kLongest - 1 && byte > 1) {
      bytes.Fail(at, "a number of the file has more than 64 bits");
    }
    ++at;
    value |= static_cast<uint64_t>(byte & 0x7fU) << (7 * i);
    if ((byte & 0x80U) == 0) {
      return value;
    }
  }
  bytes.Fail(at, "a number of the file has no end");
}

}  // namespace

void ForEachField(const nn::Bytes& message, const std::function<void(const ProtobufField&)>& take) {
  constexpr const char* kWhat = "a field of the file";
  uint64_t at = 0;
  while (at < message.size()) {
    const uint64_t start = at;
    const uint64_t key = ReadVarint(message, at);
    ProtobufField field{.number = key >> 3, .bytes = message.Slice(start, 0, kWhat)};
    if (field.number == 0) {
      message.Fail(start, "a field of the file has number 0, which protobuf does not have");
    }
    switch (key & 7) {
      case 0:
        field.value = ReadVarint(message, at);
        break;
      case 1:
        field.type = Type::kFixed64;
        field.value = message.U64(at, kWhat);
        at += sizeof(uint64_t);
        break;
      case 2: {
        field.type = Type::kBytes;
        const uint64_t size = ReadVarint(message, at);
        field.bytes = message.Slice(at, size, kWhat);
        at += size;
        break;
      }
      case 5:
        field.type = Type::kFixed32;
        field.value = message.U32(at, kWhat);
        at += sizeof(uint32_t);
        break;
      default:
        message.Fail(start, "a field of the file has type " + std::to_string(key & 7) +
                                ", which protobuf does not have");
    }
    take(field);
  }
}

void AppendVarints(const ProtobufField& field, std::vector<uint64_t>& numbers) {
  if (field.type == Type::kVarint) {
    numbers.push_back(field.value);
    return;
  }
  if (field.type != Type::kBytes) {
    field.bytes.Fail(0, "a list of numbers of the file is none");
  }
  for (uint64_t at = 0; at < field.bytes.size();) {
    numbers.push_back(ReadVarint(field.bytes, at));
  }
}

}  // namespace gluevo::weights_tools
