#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gluevo/nn/bytes.h"

namespace gluevo::weights_tools {

/// Place of an object in Pickle::objects. Objects refer to each other by it, so that nothing is
/// recursive: not the objects, however deep a file nests them, and not their destruction.
using PickleRef = uint32_t;

/// An object of a pickle, as data: nothing in a file names code that would be run.
struct PickleObject {
  enum class Kind {
    kNone,
    kBool,     ///< integer
    kInt,      ///< integer; text holds the bytes where they are more than eight
    kFloat,    ///< its value is of no use and left out
    kString,   ///< text
    kTuple,    ///< items
    kList,     ///< items
    kDict,     ///< items: key, value, key, value, ...
    kGlobal,   ///< text: "module name", one of a fixed list
    kStorage,  ///< text: key; items: its kGlobal; integer: number of elements
    kTensor,   ///< items: its kStorage; integer: offset; numbers: extents, then strides
  };
  Kind kind = Kind::kNone;
  uint64_t at = 0;  ///< Offset in the pickle of the opcode that made it.
  int64_t integer = 0;
  std::string text;
  std::vector<PickleRef> items;
  std::vector<int64_t> numbers;
};

struct Pickle {
  std::vector<PickleObject> objects;
  PickleRef root = 0;
  uint64_t size = 0;  ///< Bytes up to and with its end; others may follow.

  const PickleObject& operator[](PickleRef ref) const { return objects[ref]; }
  /// The value under a key of a dictionary, or null. The last one, as in Python.
  const PickleObject* Find(const PickleObject& dictionary, const std::string& key) const;
};

/// Reads one pickle (protocol 2 to 5) from the start of `bytes`, by a machine that knows the
/// opcodes that dictionaries of tensors need, and no others; and of globals
/// collections.OrderedDict, torch.Size, torch's storage types and torch._utils' _rebuild_tensor,
/// _rebuild_tensor_v2 and _rebuild_parameter, which it carries out itself. Throws Error, naming
/// offset and opcode or global, for anything else, and for more than a million objects.
Pickle ReadPickle(const nn::Bytes& bytes);

}  // namespace gluevo::weights_tools
