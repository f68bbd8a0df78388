#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "gluevo/nn/bytes.h"

namespace gluevo::weights_tools {

/// One field of a message in protobuf's wire format
/// (https://protobuf.dev/programming-guides/encoding).
struct ProtobufField {
  enum class Type { kVarint, kFixed64, kBytes, kFixed32 };
  uint64_t number = 0;
  Type type = Type::kVarint;
  uint64_t value = 0;  ///< Of kVarint, kFixed64 and kFixed32.
  nn::Bytes bytes;     ///< Of kBytes; else the field itself.

  std::string Text() const { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }
};

/// Calls `take` with each field of a message in order. Throws Error with the offset for broken
/// varints, lengths beyond the message, field number 0 and groups.
void ForEachField(const nn::Bytes& message, const std::function<void(const ProtobufField&)>& take);

/// The numbers of a repeated integer field, which may come packed or one by one.
void AppendVarints(const ProtobufField& field, std::vector<uint64_t>& numbers);

}  // namespace gluevo::weights_tools
