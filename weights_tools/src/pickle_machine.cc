#include "pickle_machine.h"

#include <algorithm>
#include <set>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/tensor.h"

namespace gluevo::weights_tools {
namespace {

// A full training checkpoint of these networks has some ten thousand.
constexpr std::size_t kMostObjects = 1'000'000;

const std::set<std::string>& KnownGlobals() {
  static const std::set<std::string> kKnown = {
      "collections OrderedDict",
      "torch Size",
      "torch HalfStorage",
      "torch BFloat16Storage",
      "torch FloatStorage",
      "torch DoubleStorage",
      "torch LongStorage",
      "torch IntStorage",
      "torch ShortStorage",
      "torch CharStorage",
      "torch ByteStorage",
      "torch BoolStorage",
      "torch._utils _rebuild_tensor",
      "torch._utils _rebuild_tensor_v2",
      "torch._utils _rebuild_parameter",
  };
  return kKnown;
}

}  // namespace

PickleRef PickleMachine::Push(PickleObject object) {
  if (objects_.size() == kMostObjects) {
    Fail("the pickle has more than " + std::to_string(kMostObjects) + " objects");
  }
  object.at = at_;
  const auto ref = static_cast<PickleRef>(objects_.size());
  objects_.push_back(std::move(object));
  stack_.push_back(ref);
  return ref;
}

PickleRef PickleMachine::Pop() {
  if (stack_.size() <= (marks_.empty() ? 0 : marks_.back())) {
    Fail("the pickle takes an object from an empty stack");
  }
  const PickleRef ref = stack_.back();
  stack_.pop_back();
  return ref;
}

std::vector<PickleRef> PickleMachine::PopToMark() {
  if (marks_.empty()) {
    Fail("the pickle has no mark here");
  }
  const auto begin = stack_.begin() + static_cast<std::ptrdiff_t>(marks_.back());
  std::vector<PickleRef> items(begin, stack_.end());
  stack_.erase(begin, stack_.end());
  marks_.pop_back();
  return items;
}

void PickleMachine::MakeTuple(std::size_t count) {
  PickleObject tuple{.kind = Kind::kTuple};
  for (std::size_t i = 0; i < count; ++i) {
    tuple.items.push_back(Pop());
  }
  std::reverse(tuple.items.begin(), tuple.items.end());
  Push(std::move(tuple));
}

void PickleMachine::Append(std::vector<PickleRef> items) {
  const PickleRef list = Pop();
  if (Get(list).kind != Kind::kList) {
    Fail("the pickle appends to what is no list");
  }
  std::vector<PickleRef>& all = objects_[list].items;
  all.insert(all.end(), items.begin(), items.end());
  stack_.push_back(list);
}

void PickleMachine::SetItems(std::vector<PickleRef> items) {
  const PickleRef dictionary = Pop();
  if (Get(dictionary).kind != Kind::kDict) {
    Fail("the pickle sets items of what is no dictionary");
  }
  if (items.size() % 2 != 0) {
    Fail("the pickle sets a key without a value");
  }
  std::vector<PickleRef>& all = objects_[dictionary].items;
  all.insert(all.end(), items.begin(), items.end());
  stack_.push_back(dictionary);
}

void PickleMachine::Memoize(uint64_t index) {
  const PickleRef ref = Pop();
  memo_[index] = ref;
  stack_.push_back(ref);
}

void PickleMachine::Recall(uint64_t index) {
  const auto found = memo_.find(index);
  if (found == memo_.end()) {
    Fail("the pickle recalls memo " + std::to_string(index) + ", which was never set");
  }
  stack_.push_back(found->second);
}

void PickleMachine::PushGlobal(const std::string& module, const std::string& name) {
  const std::string text = module + " " + name;
  if (!KnownGlobals().contains(text)) {
    Fail("the pickle asks for " + Quoted(module + "." + name) +
         ", which weights do not need and which is never run: expected a dictionary of tensors, as "
         "torch.save(model.state_dict(), FILE) writes");
  }
  PushText(Kind::kGlobal, text);
}

void PickleMachine::PushGlobalFromStack() {
  const PickleRef name = Pop();
  const PickleRef module = Pop();
  PushGlobal(Text(module, "a global's module"), Text(name, "a global's name"));
}

std::string PickleMachine::Text(PickleRef ref, const char* what) const {
  if (Get(ref).kind != Kind::kString) {
    Fail(std::string("the pickle gives no string for ") + what);
  }
  return Get(ref).text;
}

std::vector<int64_t> PickleMachine::Numbers(PickleRef ref, const char* what) const {
  const PickleObject& tuple = Get(ref);
  if (tuple.kind != Kind::kTuple || tuple.items.size() > nn::Shape::kMaxRank) {
    Fail(std::string("a tensor's ") + what + " are no tuple of at most " +
         std::to_string(nn::Shape::kMaxRank) + " numbers");
  }
  std::vector<int64_t> numbers;
  for (const PickleRef item : tuple.items) {
    if (Get(item).kind != Kind::kInt || !Get(item).text.empty() || Get(item).integer < 0) {
      Fail(std::string("a tensor's ") + what + " are no positive numbers");
    }
    numbers.push_back(Get(item).integer);
  }
  return numbers;
}

PickleObject PickleMachine::RebuildTensor(const std::vector<PickleRef>& arguments) const {
  // Storage, offset, extents, strides; then what training needs.
  if (arguments.size() < 4 || arguments.size() > 7) {
    Fail("a tensor is made of " + std::to_string(arguments.size()) + " arguments, expected 4 to 7");
  }
  const PickleObject& offset = Get(arguments[1]);
  if (Get(arguments[0]).kind != Kind::kStorage) {
    Fail("a tensor is not made of a storage");
  }
  if (offset.kind != Kind::kInt || !offset.text.empty() || offset.integer < 0) {
    Fail("a tensor's offset is no positive number");
  }
  std::vector<int64_t> numbers = Numbers(arguments[2], "extents");
  const std::vector<int64_t> strides = Numbers(arguments[3], "strides");
  if (numbers.size() != strides.size()) {
    Fail("a tensor has " + std::to_string(numbers.size()) + " extents and " +
         std::to_string(strides.size()) + " strides");
  }
  numbers.insert(numbers.end(), strides.begin(), strides.end());
  return {.kind = Kind::kTensor,
          .integer = offset.integer,
          .items = {arguments[0]},
          .numbers = std::move(numbers)};
}

void PickleMachine::Reduce() {
  const PickleRef arguments = Pop();
  const PickleRef function = Pop();
  if (Get(function).kind != Kind::kGlobal || Get(arguments).kind != Kind::kTuple) {
    Fail("the pickle calls what is no function");
  }
  const std::string& name = Get(function).text;
  const std::vector<PickleRef>& items = Get(arguments).items;
  // Their first argument is all that counts.
  const bool wraps =
      (name == "torch Size" && items.size() == 1 && Get(items[0]).kind == Kind::kTuple) ||
      (name == "torch._utils _rebuild_parameter" && items.size() == 3 &&
       Get(items[0]).kind == Kind::kTensor);
  if (name == "collections OrderedDict" && items.empty()) {
    PushKind(Kind::kDict);
  } else if (wraps) {
    stack_.push_back(items[0]);
  } else if (name == "torch._utils _rebuild_tensor" || name == "torch._utils _rebuild_tensor_v2") {
    Push(RebuildTensor(items));
  } else {
    Fail("the pickle calls " + Quoted(name) + " with arguments that it does not take");
  }
}

void PickleMachine::Build() {
  Pop();
  const PickleRef object = Pop();
  if (Get(object).kind != Kind::kDict) {
    Fail("the pickle sets attributes of what is no dictionary");
  }
  stack_.push_back(object);
}

void PickleMachine::PersistentId() {
  const PickleRef ref = Pop();
  const PickleObject& id = Get(ref);
  if (id.kind != Kind::kTuple || id.items.size() < 5 || id.items.size() > 6 ||
      Text(id.items[0], "a persistent id") != "storage") {
    Fail("a persistent id is not ('storage', type, key, device, size)");
  }
  const PickleObject& type = Get(id.items[1]);
  const PickleObject& size = Get(id.items[4]);
  if (type.kind != Kind::kGlobal || !type.text.ends_with("Storage")) {
    Fail("a storage has no type");
  }
  if (size.kind != Kind::kInt || !size.text.empty() || size.integer < 0) {
    Fail("a storage's size is no positive number");
  }
  if (id.items.size() == 6 && Get(id.items[5]).kind != Kind::kNone) {
    Fail(
        "a storage is a view of another, as PyTorch wrote before 0.4: save it again with a later "
        "version");
  }
  Push({.kind = Kind::kStorage,
        .integer = size.integer,
        .text = Text(id.items[2], "a storage's key"),
        .items = {id.items[1]}});
}

Pickle PickleMachine::Finish(uint64_t size) {
  const PickleRef root = Pop();
  if (!stack_.empty() || !marks_.empty()) {
    Fail("the pickle ends with objects left over");
  }
  return {std::move(objects_), root, size};
}

}  // namespace gluevo::weights_tools
