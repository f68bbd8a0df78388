#include "foreign_input.h"

#include <array>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "gluevo/nn/stand_in.h"
#include "gluevo/vo/io/image_file.h"
#include "text_file.h"

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
                           {0,
                            "\xFD"
                            "7zXZ"sv,
                            "an xz archive"},
                           {257, "ustar"sv, "a tar archive"},
                           {4, "ftyp"sv, "a video"},
                           {8, "AVI "sv, "a video"},
                           {0, "\x1A\x45\xDF\xA3"sv, "a video"},
                           {0, "MATLAB 5.0 MAT-file"sv, "a MATLAB file (mat)"},
                           {0, "MATLAB 7.3 MAT-file"sv, "a MATLAB file (mat)"},
                           {0, "\x93NUMPY"sv, "a NumPy array (npy)"},
                           {0, "\x80\x02"sv, "a pickle of Python"},
                           {0, "\x80\x03"sv, "a pickle of Python"},
                           {0, "\x80\x04"sv, "a pickle of Python"},
                           {0, "\x80\x05"sv, "a pickle of Python"},
                           {0, "%PDF"sv, "a PDF document"},
                           {0, "\x89PNG"sv, "an image"},
                           {0, "\xFF\xD8\xFF"sv, "an image"},
                           {0, "\x89HDF"sv, "an HDF5 file"}};

struct Ending {
  std::string_view ending;
  const char* name;
};

// Their first bytes are those of what they are packed in.
constexpr Ending kPackedEndings[] = {{".svo", "a recording of a ZED camera (svo)"},
                                     {".svo2", "a recording of a ZED camera (svo2)"},
                                     {".npz", "NumPy arrays (npz)"}};

constexpr Ending kEndings[] = {{".bag", "a ROS bag"},         {".mcap", "a ROS 2 bag (mcap)"},
                               {".db3", "a ROS 2 bag (db3)"}, {".mp4", "a video"},
                               {".mov", "a video"},           {".avi", "a video"},
                               {".mkv", "a video"},           {".webm", "a video"},
                               {".zip", "a zip archive"},     {".tar", "a tar archive"},
                               {".gz", "a gzip archive"},     {".tgz", "a gzip archive"},
                               {".7z", "a 7z archive"},       {".yaml", "a yaml file"},
                               {".yml", "a yaml file"},       {".txt", "a text file"},
                               {".csv", "a csv file"}};

std::string LowerEnding(const fs::path& file) { return Lowercase(file.extension().string()); }

template <std::size_t count>
std::string NameOfEnding(const Ending (&endings)[count], const fs::path& file) {
  const std::string ending = LowerEnding(file);
  for (const Ending& known : endings) {
    if (ending == known.ending) {
      return known.name;
    }
  }
  return "";
}

}  // namespace

std::string WhatBytesAre(std::string_view beginning) {
  for (const Kind& kind : kKinds) {
    if (beginning.size() >= kind.offset && beginning.substr(kind.offset).starts_with(kind.bytes)) {
      return kind.name;
    }
  }
  const std::optional<nn::StandIn> stand_in = nn::FindStandIn(beginning);
  return stand_in ? std::string(stand_in->what) + " (" + stand_in->advice + ")" : "";
}

std::string WhatFileIs(const fs::path& file) {
  std::array<char, 512> buffer = {};
  std::ifstream stream(file, std::ios::binary);
  stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  const std::string_view head(buffer.data(), static_cast<std::size_t>(stream.gcount()));
  for (const std::string& name :
       {NameOfEnding(kPackedEndings, file), WhatBytesAre(head), NameOfEnding(kEndings, file)}) {
    if (!name.empty()) {
      return name;
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
    const std::string what = fs::is_regular_file(entry->path(), ignored) ? WhatFileIs(entry->path())
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
