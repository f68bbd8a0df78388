#include "gluevo/nn/input_file.h"

#include <openssl/evp.h>

#include <fstream>
#include <string_view>
#include <system_error>

#include "gluevo/nn/error.h"

namespace gluevo::nn {
namespace {

// Weights are of tens of megabytes, with what training adds of some hundreds.
constexpr uint64_t kLargestFile = uint64_t{4} << 30;

}  // namespace

InputFile ReadInputFile(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) {
    throw Error(path.string() + ": there is no such file");
  }
  if (std::filesystem::is_directory(status)) {
    throw Error(path.string() + ": is a folder, expected a file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw Error(path.string() + ": is not a file");
  }
  std::ifstream stream(path, std::ios::binary);
  const uint64_t size = stream ? std::filesystem::file_size(path, code) : 0;
  if (!stream || code) {
    throw Error(path.string() + ": cannot be read");
  }
  if (size > kLargestFile) {
    throw Error(path.string() + ": is of " + std::to_string(size) + " bytes, at most " +
                std::to_string(kLargestFile) + " are read");
  }
  InputFile file{std::make_unique_for_overwrite<char[]>(size), size};
  stream.read(file.data.get(), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(stream.gcount()) != size) {
    throw Error(path.string() + ": byte " + std::to_string(stream.gcount()) +
                ": cannot be read on from here");
  }
  return file;
}

std::string Sha256(const void* bytes, std::size_t size) {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int digest_size = 0;
  if (EVP_Digest(bytes, size, digest, &digest_size, EVP_sha256(), nullptr) != 1) {
    throw Error("OpenSSL cannot compute SHA-256");
  }
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < digest_size; ++i) {
    text += kDigits[digest[i] >> 4];
    text += kDigits[digest[i] & 15];
  }
  return text;
}

}  // namespace gluevo::nn
