// Which files are images.

#include <algorithm>
#include <map>
#include <system_error>

#include "foreign_input.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr const char* kEndings[] = {".png", ".jpg", ".jpeg", ".jpe",  ".jfif",
                                    ".pgm", ".ppm", ".pnm",  ".pbm",  ".bmp",
                                    ".dib", ".tif", ".tiff", ".webp", ".jp2"};

std::string LowerEnding(const fs::path& name) { return Lowercase(name.extension().string()); }

// What is in a folder and not hidden, sorted.
std::vector<fs::path> Visible(const fs::path& folder) {
  std::error_code code;
  std::vector<fs::path> paths;
  for (auto entry = fs::directory_iterator(folder, code);
       !code && entry != fs::directory_iterator(); entry.increment(code)) {
    if (!entry->path().filename().string().starts_with('.')) {
      paths.push_back(entry->path());
    }
  }
  if (code) {
    throw Error(folder.string() + ": cannot be listed: " + code.message());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

bool IsFolder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

// `above`: the folders on the way, which a link must not lead back to.
void AddImagesBelow(const fs::path& folder, std::vector<fs::path> above,
                    std::vector<fs::path>& images) {
  const fs::path real = fs::canonical(folder);
  if (std::find(above.begin(), above.end(), real) != above.end()) {
    return;
  }
  above.push_back(real);
  for (const fs::path& path : Visible(folder)) {
    if (IsFolder(path)) {
      AddImagesBelow(path, above, images);
    } else if (HasImageEnding(path)) {
      images.push_back(path);
    }
  }
}

std::string What(const fs::path& folder) {
  std::map<std::string, int> files;
  int folders = 0;
  for (const fs::path& path : Visible(folder)) {
    if (IsFolder(path)) {
      ++folders;
    } else {
      ++files[LowerEnding(path)];
    }
  }
  if (files.empty()) {
    return folders == 0 ? "the folder is empty" : "there are only folders in it";
  }
  const auto most = std::max_element(
      files.begin(), files.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::string ending = most->first.empty() ? "without an ending" : Quoted(most->first);
  return "there are files " + ending + " (" + std::to_string(most->second) +
         "), expected .png, .jpg, .pgm, .ppm, .bmp, .tif, .webp or .jp2";
}

}  // namespace

bool HasImageEnding(const fs::path& name) {
  return std::find(std::begin(kEndings), std::end(kEndings), LowerEnding(name)) !=
         std::end(kEndings);
}

std::vector<fs::path> ListImages(const fs::path& folder) {
  std::vector<fs::path> images = Visible(folder);
  std::erase_if(images,
                [](const fs::path& path) { return !HasImageEnding(path) || IsFolder(path); });
  return images;
}

std::vector<fs::path> ListImagesBelow(const fs::path& folder) {
  if (!IsFolder(folder)) {
    std::error_code ignored;
    throw Error(folder.string() + (fs::exists(folder, ignored)
                                       ? ": " + WhatFileIs(folder) +
                                             ", expected a folder of images (extract those of a "
                                             "recording or an archive first)"
                                       : ": no such folder"));
  }
  std::vector<fs::path> images;
  AddImagesBelow(folder, {}, images);
  if (images.empty()) {
    throw Error(NoImagesMessage(folder) + "; looked in the folders below it, too");
  }
  std::sort(images.begin(), images.end());
  return images;
}

std::string NoImagesMessage(const fs::path& folder) {
  return folder.string() + ": no images in it: " + What(folder);
}

}  // namespace gluevo::vo
