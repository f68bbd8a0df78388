#include "foreign_input.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "gluevo/vo/io/image_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;
using std::string_view_literals::operator""sv;

struct Kind {
  std::size_t offset;
  std::string_view bytes;
  const char* name;
};

constexpr Kind kKinds[] = {{0, "#ROSBAG"sv, "a ROS bag"},
                           {0, "\x89MCAP"sv, "a ROS 2 bag (mcap)"},
                           {0, "SQLite format 3"sv, "a database, as ROS 2 bags are (db3)"},
                           {0, "PK\x03\x04"sv, "a zip archive"},
                           {0, "\x1F\x8B"sv, "a gzip archive"},
                           {0, "7z\xBC\xAF"sv, "a 7z archive"},
                           {0, "Rar!"sv, "a rar archive"},
                           {0, "\xFD" "7zXZ"sv, "an xz archive"},
                           {257, "ustar"sv, "a tar archive"},
                           {4, "ftyp"sv, "a video"},
                           {8, "AVI "sv, "a video"},
                           {0, "\x1A\x45\xDF\xA3"sv, "a video"},
                           {0, "\x89HDF"sv, "an HDF5 file"}};

struct Ending {
  std::string_view ending;
  const char* name;
};

constexpr Ending kEndings[] = {{".bag", "a ROS bag"},
                               {".mcap", "a ROS 2 bag (mcap)"},
                               {".db3", "a ROS 2 bag (db3)"},
                               {".svo", "a recording of a ZED camera (svo)"},
                               {".svo2", "a recording of a ZED camera (svo2)"},
                               {".mp4", "a video"},
                               {".mov", "a video"},
                               {".avi", "a video"},
                               {".mkv", "a video"},
                               {".webm", "a video"},
                               {".zip", "a zip archive"},
                               {".tar", "a tar archive"},
                               {".gz", "a gzip archive"},
                               {".tgz", "a gzip archive"},
                               {".7z", "a 7z archive"},
                               {".yaml", "a yaml file"},
                               {".yml", "a yaml file"},
                               {".txt", "a text file"},
                               {".csv", "a csv file"}};

std::string LowerEnding(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

}  // namespace

std::string WhatFileIs(const fs::path& file) {
  std::array<char, 512> buffer = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  const std::string_view head(buffer.data(), static_cast<std::size_t>(stream.gcount()));
  for (const Kind& kind : kKinds) {
    if (head.size() >= kind.offset && head.substr(kind.offset).starts_with(kind.bytes)) {
      return kind.name;
    }
  }
  const std::string ending = LowerEnding(file);
  for (const Ending& known : kEndings) {
    if (ending == known.ending) {
      return known.name;
    }
  }
  return HasImageEnding(file) ? "an image" : "a file";
}

std::string ForeignFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  std::error_code ignored;
  for (auto entry = fs::directory_iterator(folder, code);
       !code && entry != fs::directory_iterator(); entry.increment(code)) {
    const std::string what = fs::is_regular_file(entry->path(), ignored)
                                 ? WhatFileIs(entry->path())
                                 : std::string("a folder");
    for (const char* const kind : {"bag", "recording", "video", "archive"}) {
      if (what.find(kind) != std::string::npos) {
        files.push_back(entry->path());
      }
    }
  }
  if (files.empty()) {
    return "";
  }
  const fs::path& first = *std::min_element(files.begin(), files.end());
  return "; " + first.filename().string() + " in it is " + WhatFileIs(first) +
         ", whose images have to be extracted first";
}

}  // namespace gluevo::vo
