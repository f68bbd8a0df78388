#include "gluevo/nn/foreign_file.h"

#include <algorithm>
#include <string_view>

#include "gluevo/nn/error.h"
#include "gluevo/nn/stand_in.h"

namespace gluevo::nn {
namespace {

constexpr const char* kUnpack = ": unpack it first";

struct Signature {
  std::size_t offset;
  std::string_view bytes;
  const char* what;
  std::string_view advice;  ///< Empty where there is none but to take another file.
};

constexpr Signature kSignatures[] = {
    {257, "ustar", "a tar archive",
     ": unpack it, or, where PyTorch wrote it before 0.1.10, save it again with a later version"},
    {0, "\x1f\x8b", "compressed by gzip", kUnpack},
    {0, "BZh", "compressed by bzip2", kUnpack},
    {0,
     "\xfd"
     "7zXZ",
     "compressed by xz", kUnpack},
    {0, "\x28\xb5\x2f\xfd", "compressed by Zstandard", kUnpack},
    {0, "7z\xbc\xaf\x27\x1c", "a 7z archive", kUnpack},
    {0, "Rar!\x1a\x07", "a RAR archive", kUnpack},
    {0, "\x89HDF", "HDF5", ""},
    {0, "GGUF", "GGUF", ""},
    {0, "\x89PNG", "an image", ""},
    {0, "\xff\xd8\xff", "an image", ""},
    {0, "%PDF", "a PDF document", ""},
    {0,
     "\x7f"
     "ELF",
     "a program", ""},
};

bool IsShortAscii(std::string_view text) {
  constexpr std::size_t kLongestMessage = 2000;
  return text.size() <= kLongestMessage && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= ' ' && c <= '~') || c == '\n' || c == '\r' || c == '\t';
         });
}

}  // namespace

std::optional<std::string> ForeignForm(const Bytes& file, std::string_view expected) {
  const std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  const std::optional<StandIn> stand_in = FindStandIn(text);
  if (stand_in && !stand_in->is_page) {
    return std::string(stand_in->what) + ": " + stand_in->advice;
  }
  for (const Signature& signature : kSignatures) {
    if (text.size() > signature.offset &&
        text.substr(signature.offset).starts_with(signature.bytes)) {
      return signature.what + (signature.advice.empty() ? ", expected " + std::string(expected)
                                                        : std::string(signature.advice));
    }
  }
  const auto not_downloaded = [&](const std::string& what) {
    return what + ", expected " + std::string(expected) +
           ": was it not downloaded as it should be?";
  };
  if (stand_in) {
    return not_downloaded(stand_in->what);
  }
  if (text.starts_with("<?xml")) {
    return not_downloaded("XML");
  }
  // Servers answer "Entry not found", {"error": ...} and the like.
  if (!text.empty() && IsShortAscii(text)) {
    const std::string line(text.substr(0, std::min<std::size_t>(text.find_first_of("\r\n"), 60)));
    return not_downloaded("the text " + Quoted(line));
  }
  return std::nullopt;
}

}  // namespace gluevo::nn
