#include "pickle.h"

#include <cstring>

#include "gluevo/nn/error.h"
#include "pickle_machine.h"
#include "pickle_opcodes.h"

namespace gluevo::weights_tools {
namespace {

using Kind = PickleObject::Kind;
using Op = PickleOpcode;

constexpr uint8_t kLatestProtocol = 5;
constexpr uint64_t kLongestName = 1000;

/// Takes the opcodes' arguments from the bytes, one after the other.
class Arguments {
 public:
  explicit Arguments(const nn::Bytes& bytes) : bytes_(bytes) {}

  uint64_t position() const { return position_; }
  uint8_t U8() { return *Take(1).data(); }
  uint16_t U16() { return Take(2).U16(0, kWhat); }
  uint32_t U32() { return Take(4).U32(0, kWhat); }
  uint64_t U64() { return Take(8).U64(0, kWhat); }
  std::string Text(uint64_t size) {
    const nn::Bytes text = Take(size);
    return {reinterpret_cast<const char*>(text.data()), text.size()};
  }
  // Up to a line feed, which is not part of it.
  std::string Line() {
    const auto* begin = reinterpret_cast<const char*>(bytes_.data()) + position_;
    const uint64_t rest = bytes_.size() - position_;
    const void* end = std::memchr(begin, '\n', rest < kLongestName ? rest : kLongestName);
    if (end == nullptr) {
      bytes_.Fail(position_, "a name in the pickle has no end");
    }
    std::string line(begin, static_cast<const char*>(end));
    position_ += line.size() + 1;
    return line;
  }

 private:
  static constexpr const char* kWhat = "the pickle";
  nn::Bytes Take(uint64_t size) {
    nn::Bytes taken = bytes_.Slice(position_, size, kWhat);
    position_ += size;
    return taken;
  }

  const nn::Bytes& bytes_;
  uint64_t position_ = 0;
};

// Little-endian two's complement of any length.
PickleObject LongInteger(std::string bytes) {
  PickleObject object{.kind = Kind::kInt};
  if (bytes.size() > sizeof(int64_t)) {
    object.text = std::move(bytes);
    return object;
  }
  const bool negative = !bytes.empty() && (bytes.back() & 0x80) != 0;
  bytes.resize(sizeof(int64_t), negative ? '\xff' : '\0');
  std::memcpy(&object.integer, bytes.data(), sizeof(int64_t));
  return object;
}

// Carries out one opcode that makes an object of its arguments alone; false for the others.
bool PushConstant(Op opcode, Arguments& arguments, PickleMachine& machine) {
  switch (opcode) {
    case Op::kNone:
      machine.PushKind(Kind::kNone);
      return true;
    case Op::kNewTrue:
    case Op::kNewFalse:
      machine.Push({.kind = Kind::kBool, .integer = opcode == Op::kNewTrue ? 1 : 0});
      return true;
    case Op::kBinInt:
      machine.PushInt(static_cast<int32_t>(arguments.U32()));
      return true;
    case Op::kBinInt1:
      machine.PushInt(arguments.U8());
      return true;
    case Op::kBinInt2:
      machine.PushInt(arguments.U16());
      return true;
    case Op::kLong1:
      machine.Push(LongInteger(arguments.Text(arguments.U8())));
      return true;
    case Op::kBinFloat:
      arguments.U64();
      machine.PushKind(Kind::kFloat);
      return true;
    case Op::kBinString:
    case Op::kBinUnicode:
      machine.PushText(Kind::kString, arguments.Text(arguments.U32()));
      return true;
    case Op::kShortBinString:
    case Op::kShortBinUnicode:
      machine.PushText(Kind::kString, arguments.Text(arguments.U8()));
      return true;
    case Op::kEmptyTuple:
      machine.PushKind(Kind::kTuple);
      return true;
    case Op::kEmptyList:
      machine.PushKind(Kind::kList);
      return true;
    case Op::kEmptyDict:
      machine.PushKind(Kind::kDict);
      return true;
    default:
      return false;
  }
}

void CarryOut(Op opcode, Arguments& arguments, PickleMachine& machine) {
  switch (opcode) {
    case Op::kMark:
      return machine.Mark();
    case Op::kTuple:
      machine.Push({.kind = Kind::kTuple, .items = machine.PopToMark()});
      return;
    case Op::kTuple1:
      return machine.MakeTuple(1);
    case Op::kTuple2:
      return machine.MakeTuple(2);
    case Op::kTuple3:
      return machine.MakeTuple(3);
    case Op::kAppend:
      return machine.Append({machine.Pop()});
    case Op::kAppends:
      return machine.Append(machine.PopToMark());
    case Op::kSetItem: {
      const PickleRef value = machine.Pop();
      return machine.SetItems({machine.Pop(), value});
    }
    case Op::kSetItems:
      return machine.SetItems(machine.PopToMark());
    case Op::kBinGet:
      return machine.Recall(arguments.U8());
    case Op::kLongBinGet:
      return machine.Recall(arguments.U32());
    case Op::kBinPut:
      return machine.Memoize(arguments.U8());
    case Op::kLongBinPut:
      return machine.Memoize(arguments.U32());
    case Op::kMemoize:
      return machine.MemoizeNext();
    case Op::kGlobal: {
      const std::string module = arguments.Line();
      return machine.PushGlobal(module, arguments.Line());
    }
    case Op::kStackGlobal:
      return machine.PushGlobalFromStack();
    case Op::kReduce:
      return machine.Reduce();
    case Op::kBuild:
      return machine.Build();
    case Op::kBinPersId:
      return machine.PersistentId();
    case Op::kFrame:
      arguments.U64();
      return;
    default:
      if (!PushConstant(opcode, arguments, machine)) {
        machine.Fail("the pickle has the opcode " + PickleOpcodeName(static_cast<uint8_t>(opcode)) +
                     ", which no dictionary of tensors needs and which is never carried out");
      }
  }
}

}  // namespace

const PickleObject* Pickle::Find(const PickleObject& dictionary, const std::string& key) const {
  const PickleObject* found = nullptr;
  for (std::size_t i = 0; i + 1 < dictionary.items.size(); i += 2) {
    const PickleObject& candidate = objects[dictionary.items[i]];
    if (candidate.kind == Kind::kString && candidate.text == key) {
      found = &objects[dictionary.items[i + 1]];
    }
  }
  return found;
}

Pickle ReadPickle(const nn::Bytes& bytes) {
  Arguments arguments(bytes);
  PickleMachine machine(bytes);
  if (arguments.U8() != static_cast<uint8_t>(Op::kProto)) {
    bytes.Fail(0, "there is no pickle of protocol 2 or later here");
  }
  const uint8_t protocol = arguments.U8();
  if (protocol < 2 || protocol > kLatestProtocol) {
    bytes.Fail(1, "the pickle is of protocol " + std::to_string(protocol) + ", expected 2 to 5");
  }
  for (;;) {
    machine.SetPlace(arguments.position());
    const Op opcode{arguments.U8()};
    if (opcode == Op::kStop) {
      return machine.Finish(arguments.position());
    }
    CarryOut(opcode, arguments, machine);
  }
}

}  // namespace gluevo::weights_tools
