#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "pickle.h"
#include "state_dict.h"
#include "torch.h"

namespace gluevo::weights_tools {
namespace {

constexpr std::string_view kPickleName = "/data.pkl";

/// Entries below the folder that the pickle lies in, by their names below it.
class Archive {
 public:
  Archive(const nn::Bytes& file, const std::vector<nn::ZipEntry>& entries) {
    const nn::ZipEntry* pickle = nullptr;
    for (const nn::ZipEntry& entry : entries) {
      if (std::string_view(entry.name).ends_with(kPickleName)) {
        if (pickle != nullptr) {
          file.Fail(entry.at, "the archive has two pickles, " + Quoted(pickle->name) + " and " +
                                  Quoted(entry.name));
        }
        pickle = &entry;
      }
    }
    if (pickle == nullptr) {
      throw Error("an archive without a pickle");
    }
    const std::string prefix =
        pickle->name.substr(0, pickle->name.size() - kPickleName.size()) + '/';
    for (const nn::ZipEntry& entry : entries) {
      if (entry.name.starts_with(prefix)) {
        entries_.emplace(entry.name.substr(prefix.size()), &entry);
      }
    }
  }

  /// Null where there is no such entry.
  const nn::ZipEntry* Find(const std::string& name) const {
    const auto found = entries_.find(name);
    return found == entries_.end() ? nullptr : found->second;
  }

  /// Kept, as several tensors may share it.
  const nn::Bytes& Data(const nn::ZipEntry& entry) {
    std::unique_ptr<nn::ZipData>& data = data_[entry.name];
    if (!data) {
      data = std::make_unique<nn::ZipData>(entry);
    }
    return data->bytes();
  }

 private:
  std::map<std::string, const nn::ZipEntry*> entries_;
  std::map<std::string, std::unique_ptr<nn::ZipData>> data_;
};

void CheckByteOrder(Archive& archive) {
  const nn::ZipEntry* entry = archive.Find("byteorder");
  if (entry == nullptr) {  // PyTorch before 2.1.
    return;
  }
  const nn::Bytes& order = archive.Data(*entry);
  const std::string text(reinterpret_cast<const char*>(order.data()), order.size());
  if (text != "little") {
    order.Fail(0, "the archive's byte order is " + Quoted(text) + ", expected \"little\"");
  }
}

}  // namespace

bool IsTorchArchive(const std::vector<nn::ZipEntry>& entries) {
  for (const nn::ZipEntry& entry : entries) {
    if (std::string_view(entry.name).ends_with(kPickleName)) {
      return true;
    }
  }
  return false;
}

void ParseTorchArchive(const nn::Bytes& file, const std::vector<nn::ZipEntry>& entries,
                       nn::Weights& weights) {
  Archive archive(file, entries);
  if (const nn::ZipEntry* constants = archive.Find("constants.pkl")) {
    file.Fail(
        constants->at,
        "the archive is a TorchScript program, expected a dictionary of tensors: load it with "
        "torch.jit.load and torch.save its state_dict()");
  }
  CheckByteOrder(archive);
  const nn::Bytes& bytes = archive.Data(*archive.Find("data.pkl"));
  const Pickle pickle = ReadPickle(bytes);
  if (pickle.size != bytes.size()) {
    bytes.Fail(pickle.size,
               std::to_string(bytes.size() - pickle.size) + " trailing bytes after the pickle");
  }
  const auto bytes_of = [&](const PickleObject& storage) {
    const nn::ZipEntry* entry = archive.Find("data/" + storage.text);
    if (entry == nullptr) {
      bytes.Fail(storage.at, "there is no storage " + Quoted(storage.text) + " in the archive");
    }
    const std::size_t width = StorageElementSize(pickle, storage);
    if (entry->size % width != 0 || entry->size / width != static_cast<uint64_t>(storage.integer)) {
      file.Fail(entry->at, "storage " + Quoted(storage.text) + " has " +
                               std::to_string(entry->size) + " bytes, expected " +
                               std::to_string(storage.integer) + " elements of " +
                               std::to_string(width));
    }
    return archive.Data(*entry);
  };
  ReadStateDict(pickle, bytes, bytes_of, file.size(), weights);
}

}  // namespace gluevo::weights_tools
