#include "gluevo/nn/weights.h"

#include <openssl/evp.h>

#include <fstream>
#include <memory>
#include <string_view>
#include <system_error>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/npy.h"
#include "npz.h"
#include "safetensors.h"

namespace gluevo::nn {
namespace {

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

bool StartsWith(const Bytes& file, std::string_view start) {
  return std::string_view(reinterpret_cast<const char*>(file.data()), file.size())
      .starts_with(start);
}

}  // namespace

const Tensor<float>& Weights::Get(const std::string& name) const {
  const auto found = tensors.find(name);
  if (found == tensors.end()) {
    throw Error(source + ": there is no tensor " + Quoted(name));
  }
  return found->second;
}

const Tensor<float>& Weights::Get(const std::string& name, const Shape& expected) const {
  const Tensor<float>& tensor = Get(name);
  CheckShape(tensor.shape(), expected, source + ": tensor " + Quoted(name));
  return tensor;
}

Weights ParseWeights(const void* bytes, std::size_t size, const std::string& source) {
  const Bytes file(bytes, size, source);
  Weights weights;
  weights.source = source;
  if (size == 0) {
    file.Fail(0, "the file is empty, expected .safetensors or .npz");
  }
  if (LooksLikeSafetensors(file)) {
    ParseSafetensors(file, weights);
  } else if (StartsWith(file, "PK")) {
    ParseNpz(file, weights);
  } else if (LooksLikeNpy(file)) {
    file.Fail(0, "the file is a single .npy array, expected .safetensors or .npz");
  } else if (size <= 8 || file.data()[8] == '{' || file.U32(4, "") == 0) {
    // Meant as safetensors: says what is wrong with the header.
    ParseSafetensors(file, weights);
  } else {
    file.Fail(0, "the file is neither .safetensors nor .npz");
  }
  weights.checksum = Sha256(bytes, size);
  return weights;
}

Weights ReadWeights(const std::filesystem::path& path) {
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) {
    throw Error(path.string() + ": there is no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw Error(path.string() + ": is not a file");
  }
  std::ifstream stream(path, std::ios::binary);
  const uint64_t size = stream ? std::filesystem::file_size(path, code) : 0;
  if (!stream || code) {
    throw Error(path.string() + ": cannot be read");
  }
  const auto bytes = std::make_unique_for_overwrite<char[]>(size);
  stream.read(bytes.get(), static_cast<std::streamsize>(size));
  if (static_cast<uint64_t>(stream.gcount()) != size) {
    throw Error(path.string() + ": byte " + std::to_string(stream.gcount()) +
                ": cannot be read on from here");
  }
  return ParseWeights(bytes.get(), size, path.string());
}

}  // namespace gluevo::nn
