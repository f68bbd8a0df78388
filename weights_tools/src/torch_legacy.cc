#include <map>
#include <set>
#include <string>

#include "pickle.h"
#include "state_dict.h"
#include "torch.h"

namespace gluevo::weights_tools {
namespace {

using Kind = PickleObject::Kind;

// The number 0x1950a86a20f9469cfc6c, little-endian.
constexpr std::string_view kMagic("\x6c\xfc\x9c\x46\xf9\x20\x6a\xa8\x50\x19", 10);
constexpr int64_t kVersion = 1001;

/// Reads the file's pickles one after the other.
class PickleSequence {
 public:
  explicit PickleSequence(const nn::Bytes& file) : file_(file) {}

  uint64_t position() const { return position_; }
  Pickle Next(const std::string& what) {
    start_ = position_;
    Pickle pickle = ReadPickle(Present(what));
    position_ += pickle.size;
    return pickle;
  }
  /// The bytes of the pickle read last, and what follows.
  nn::Bytes Last() const { return file_.Slice(start_, file_.size() - start_, ""); }

 private:
  nn::Bytes Present(const std::string& what) const {
    return file_.Slice(position_, file_.size() - position_, what);
  }

  const nn::Bytes& file_;
  uint64_t start_ = 0;
  uint64_t position_ = 0;
};

void CheckHeader(const nn::Bytes& file, PickleSequence& pickles) {
  const Pickle magic = pickles.Next("the magic number");
  if (magic[magic.root].kind != Kind::kInt || magic[magic.root].text != kMagic) {
    file.Fail(0, "the file begins with a pickle but not with PyTorch's magic number");
  }
  const uint64_t version_at = pickles.position();
  const Pickle version = pickles.Next("the version");
  if (version[version.root].kind != Kind::kInt || version[version.root].integer != kVersion) {
    file.Fail(version_at, "the version of the file is not 1001");
  }
  const uint64_t system_at = pickles.position();
  const Pickle system = pickles.Next("the byte order");
  const PickleObject& properties = system[system.root];
  const PickleObject* little =
      properties.kind == Kind::kDict ? system.Find(properties, "little_endian") : nullptr;
  if (little == nullptr || little->kind != Kind::kBool) {
    file.Fail(system_at, "the file does not tell its byte order");
  }
  if (little->integer == 0) {
    file.Fail(system_at, "the file is big-endian, expected little-endian");
  }
}

// The pickle's storages by key, all references to one agreeing.
std::map<std::string, const PickleObject*> StoragesOf(const Pickle& pickle,
                                                      const nn::Bytes& bytes) {
  std::map<std::string, const PickleObject*> storages;
  for (const PickleObject& object : pickle.objects) {
    if (object.kind != Kind::kStorage) {
      continue;
    }
    const auto [found, inserted] = storages.emplace(object.text, &object);
    if (!inserted && (found->second->integer != object.integer ||
                      pickle[found->second->items[0]].text != pickle[object.items[0]].text)) {
      bytes.Fail(object.at,
                 "storage " + Quoted(object.text) + " has another size or type than before");
    }
  }
  return storages;
}

}  // namespace

bool LooksLikeTorchLegacy(const nn::Bytes& file) {
  return file.size() >= 2 && file.data()[0] == 0x80 && file.data()[1] >= 2 && file.data()[1] <= 5;
}

void ParseTorchLegacy(const nn::Bytes& file, nn::Weights& weights) {
  PickleSequence pickles(file);
  CheckHeader(file, pickles);
  const Pickle pickle = pickles.Next("the dictionary of tensors");
  const nn::Bytes bytes = pickles.Last();
  const std::map<std::string, const PickleObject*> storages = StoragesOf(pickle, bytes);

  const Pickle keys = pickles.Next("the list of storages");
  const nn::Bytes keys_bytes = pickles.Last();
  if (keys[keys.root].kind != Kind::kList) {
    keys_bytes.Fail(0, "the storages' keys are no list");
  }
  std::map<std::string, nn::Bytes> data;
  uint64_t at = pickles.position();
  for (const PickleRef ref : keys[keys.root].items) {
    const PickleObject& key = keys[ref];
    const auto found = storages.find(key.text);
    if (key.kind != Kind::kString || found == storages.end()) {
      keys_bytes.Fail(key.at, "the key " + Quoted(key.text) + " is no storage of the dictionary");
    }
    const PickleObject& storage = *found->second;
    const std::string what = "storage " + Quoted(key.text);
    const uint64_t count = file.U64(at, "the size of " + what);
    if (count != static_cast<uint64_t>(storage.integer)) {
      file.Fail(at, what + " has " + std::to_string(count) + " elements, expected " +
                        std::to_string(storage.integer));
    }
    at += sizeof(uint64_t);
    const uint64_t width = StorageElementSize(pickle, storage);
    if (count > (file.size() - at) / width) {
      file.Fail(at, what + " is cut short: " + std::to_string(count) + " elements of " +
                        std::to_string(width) + " bytes expected, " +
                        std::to_string(file.size() - at) + " bytes are there");
    }
    if (!data.emplace(key.text, file.Slice(at, count * width, what)).second) {
      keys_bytes.Fail(key.at, what + " comes twice");
    }
    at += count * width;
  }
  if (at != file.size()) {
    file.Fail(at, std::to_string(file.size() - at) + " trailing bytes after the last storage");
  }
  const auto bytes_of = [&](const PickleObject& storage) {
    const auto found = data.find(storage.text);
    if (found == data.end()) {
      bytes.Fail(storage.at, "storage " + Quoted(storage.text) + " is not in the file");
    }
    return found->second;
  };
  ReadStateDict(pickle, bytes, bytes_of, file.size(), weights);
}

}  // namespace gluevo::weights_tools
