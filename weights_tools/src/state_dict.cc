#include "state_dict.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>

namespace gluevo::weights_tools {
namespace {

using Kind = PickleObject::Kind;

constexpr int kDeepestWrapping = 4;
// Tensors may share storages, but weights do not do so hundreds of times.
constexpr uint64_t kFreeBytes = uint64_t{64} << 20;
constexpr uint64_t kMostShared = 4;

struct StorageType {
  std::size_t size;
  std::optional<nn::ElementType> type;  // None for integers.
};

StorageType TypeOf(const Pickle& pickle, const PickleObject& storage) {
  static const std::map<std::string, StorageType> kTypes = {
      {"torch HalfStorage", {2, nn::ElementType::kF16}},
      {"torch BFloat16Storage", {2, nn::ElementType::kBF16}},
      {"torch FloatStorage", {4, nn::ElementType::kF32}},
      {"torch DoubleStorage", {8, nn::ElementType::kF64}},
      {"torch LongStorage", {8, std::nullopt}},
      {"torch IntStorage", {4, std::nullopt}},
      {"torch ShortStorage", {2, std::nullopt}},
      {"torch CharStorage", {1, std::nullopt}},
      {"torch ByteStorage", {1, std::nullopt}},
      {"torch BoolStorage", {1, std::nullopt}},
  };
  return kTypes.at(pickle[storage.items[0]].text);
}

bool HasTensors(const Pickle& pickle, const PickleObject& dictionary) {
  for (std::size_t i = 1; i < dictionary.items.size(); i += 2) {
    if (pickle[dictionary.items[i]].kind == Kind::kTensor) {
      return true;
    }
  }
  return false;
}

// Each dictionary is searched once, however often others hold it.
const PickleObject* Search(const Pickle& pickle, const PickleObject& object, int depth,
                           std::set<const PickleObject*>& visited) {
  if (object.kind != Kind::kDict || depth > kDeepestWrapping || !visited.insert(&object).second) {
    return nullptr;
  }
  constexpr std::array kWrappings = {"state_dict", "model_state_dict", "model",    "net",
                                     "network",    "weights",          "params",   "superpoint",
                                     "superglue",  "matcher",          "extractor"};
  for (const char* key : kWrappings) {
    if (const PickleObject* inner = pickle.Find(object, key)) {
      if (const PickleObject* found = Search(pickle, *inner, depth + 1, visited)) {
        return found;
      }
    }
  }
  return HasTensors(pickle, object) ? &object : nullptr;
}

std::string KeysOf(const Pickle& pickle, const PickleObject& dictionary) {
  constexpr std::size_t kMost = 5;
  std::string keys;
  for (std::size_t i = 0; i < dictionary.items.size(); i += 2) {
    if (i == 2 * kMost) {
      return keys + ", ...";
    }
    const PickleObject& key = pickle[dictionary.items[i]];
    keys += (i > 0 ? ", " : "") +
            (key.kind == Kind::kString ? Quoted(key.text) : std::string("no string"));
  }
  return keys;
}

nn::Tensor<float> ReadTensor(const PickleObject& tensor, const nn::Bytes& storage,
                             nn::ElementType type, const nn::Shape& shape,
                             const std::string& name) {
  nn::Strides strides = {};
  std::copy_n(tensor.numbers.begin() + shape.rank(), shape.rank(), strides.begin());
  return nn::ReadStrided(storage, type, shape, strides, static_cast<uint64_t>(tensor.integer),
                         name);
}

}  // namespace

const PickleObject& FindStateDict(const Pickle& pickle, const nn::Bytes& bytes) {
  const PickleObject& root = pickle[pickle.root];
  if (root.kind != Kind::kDict) {
    bytes.Fail(root.at,
               "the pickle holds no dictionary: expected one of tensors, as "
               "torch.save(model.state_dict(), FILE) writes");
  }
  std::set<const PickleObject*> visited;
  const PickleObject* found = Search(pickle, root, 0, visited);
  if (found == nullptr) {
    bytes.Fail(root.at, root.items.empty()
                            ? std::string("the pickled dictionary is empty, expected tensors")
                            : "the pickled dictionary holds no tensors, only the keys " +
                                  KeysOf(pickle, root));
  }
  return *found;
}

std::size_t StorageElementSize(const Pickle& pickle, const PickleObject& storage) {
  return TypeOf(pickle, storage).size;
}

void ReadStateDict(const Pickle& pickle, const nn::Bytes& bytes,
                   const std::function<nn::Bytes(const PickleObject& storage)>& bytes_of,
                   uint64_t file_size, nn::Weights& weights) {
  const PickleObject& dictionary = FindStateDict(pickle, bytes);
  uint64_t total = 0;
  for (std::size_t i = 0; i + 1 < dictionary.items.size(); i += 2) {
    const PickleObject& key = pickle[dictionary.items[i]];
    const PickleObject& tensor = pickle[dictionary.items[i + 1]];
    if (tensor.kind != Kind::kTensor) {
      continue;
    }
    if (key.kind != Kind::kString) {
      bytes.Fail(key.at, "a tensor's name is no string");
    }
    const std::string& name = key.text;
    const std::string subject = "tensor " + Quoted(name);
    const PickleObject& storage = pickle[tensor.items[0]];
    const StorageType type = TypeOf(pickle, storage);
    if (!type.type) {
      if (nn::IsTrainingCounter(name)) {
        continue;
      }
      bytes.Fail(tensor.at, subject + " is of " + Quoted(pickle[storage.items[0]].text) +
                                ", expected half, bfloat16, float or double");
    }
    nn::Shape shape;
    try {
      shape = nn::Shape(tensor.numbers.data(), tensor.numbers.size() / 2);
    } catch (const Error& error) {
      bytes.Fail(tensor.at, subject + ": " + error.what());
    }
    total += static_cast<uint64_t>(shape.size()) * sizeof(float);
    if (total > kFreeBytes + kMostShared * file_size) {
      bytes.Fail(tensor.at, "with " + subject + " the tensors are more than " +
                                std::to_string(kMostShared) + " times the file's size");
    }
    if (!weights.tensors
             .emplace(name, ReadTensor(tensor, bytes_of(storage), *type.type, shape, name))
             .second) {
      bytes.Fail(key.at, subject + " comes twice");
    }
  }
}

}  // namespace gluevo::weights_tools
