#pragma once

#include <cstddef>
#include <string>
#include <unordered_map>
#include <vector>

#include "pickle.h"

namespace gluevo::weights_tools {

/// Stack, marks and memo of the machine that ReadPickle is. Every operation throws Error with the
/// offset of the present opcode where the stack or the memo does not hold what it needs.
class PickleMachine {
 public:
  using Kind = PickleObject::Kind;

  explicit PickleMachine(const nn::Bytes& bytes) : bytes_(bytes) {}

  /// The offset that objects and errors get from now on.
  void SetPlace(uint64_t at) { at_ = at; }
  [[noreturn]] void Fail(const std::string& message) const { bytes_.Fail(at_, message); }

  PickleRef Push(PickleObject object);
  void PushKind(Kind kind) { Push({.kind = kind}); }
  void PushInt(int64_t value) { Push({.kind = Kind::kInt, .integer = value}); }
  void PushText(Kind kind, std::string text) { Push({.kind = kind, .text = std::move(text)}); }

  void Mark() { marks_.push_back(stack_.size()); }
  /// What lies above the last mark, which goes with it.
  std::vector<PickleRef> PopToMark();
  PickleRef Pop();
  /// The topmost `count` objects as a tuple.
  void MakeTuple(std::size_t count);

  void Append(std::vector<PickleRef> items);
  void SetItems(std::vector<PickleRef> items);

  void Memoize(uint64_t index);
  void MemoizeNext() { Memoize(memo_.size()); }
  void Recall(uint64_t index);

  /// Pushes the global of this name, or throws Error where it is not one of the list.
  void PushGlobal(const std::string& module, const std::string& name);
  void PushGlobalFromStack();
  /// Calls the global below the tuple on top with it.
  void Reduce();
  /// Drops the state on top: the attributes of a dictionary say nothing about its tensors.
  void Build();
  /// Turns the tuple ('storage', type, key, device, size) on top to the storage it names.
  void PersistentId();

  /// The pickle that ends here.
  Pickle Finish(uint64_t size);

 private:
  const PickleObject& Get(PickleRef ref) const { return objects_[ref]; }
  std::string Text(PickleRef ref, const char* what) const;
  PickleObject RebuildTensor(const std::vector<PickleRef>& arguments) const;
  std::vector<int64_t> Numbers(PickleRef ref, const char* what) const;

  const nn::Bytes& bytes_;
  uint64_t at_ = 0;
  std::vector<PickleObject> objects_;
  std::vector<PickleRef> stack_;
  std::vector<std::size_t> marks_;
  std::unordered_map<uint64_t, PickleRef> memo_;
};

}  // namespace gluevo::weights_tools
