// Where data sets keep the times of their images.

#include <algorithm>
#include <cstdint>
#include <system_error>

#include "gluevo/nn/error.h"
#include "name_parts.h"
#include "times_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::string LowerStem(const fs::path& path) {
  std::string text;
  for (const NameWord& word : WordsOf(path.stem().string())) {
    text += (text.empty() ? "" : "_") + word.text;
  }
  return text;
}

bool IsText(const fs::path& path) {
  std::error_code ignored;
  const std::string ending = path.extension().string();
  return !path.filename().string().starts_with('.') && fs::is_regular_file(path, ignored) &&
         (ending == ".txt" || ending == ".csv" || ending == ".TXT" || ending == ".CSV");
}

// times.txt and timestamps.csv, but not pose_timestamps.txt.
bool IsTimesName(const std::string& stem) {
  const auto holds = [&](const char* word) { return stem.find(word) != std::string::npos; };
  return (holds("time") || holds("stamp")) && !holds("pose") && !holds("imu") && !holds("truth") &&
         !holds("trajectory") && !holds("exposure") && !holds("runtime") && !holds("timing") &&
         !holds("gps") && !holds("oxts");
}

std::vector<fs::path> TextFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code code;
  for (auto entry = fs::directory_iterator(folder, code);
       !code && entry != fs::directory_iterator(); entry.increment(code)) {
    if (IsText(entry->path())) {
      files.push_back(entry->path());
    }
  }
  // The shortest name first: times.txt before times_raw.txt.
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    const std::size_t first = a.filename().string().size();
    const std::size_t second = b.filename().string().size();
    return first != second ? first < second : a < b;
  });
  return files;
}

// The folder of a camera that lies in `root`: left of left/data.
fs::path FolderBelow(const fs::path& root, const fs::path& folder) {
  const fs::path relative = folder.lexically_relative(root);
  return relative.empty() || *relative.begin() == ".." ? folder : root / *relative.begin();
}

// rgb.txt, associations.txt and their like: rows that name images which are there.
bool NamesImages(const fs::path& file, const fs::path& root,
                 const std::array<fs::path, 2>& folders) {
  std::error_code ignored;
  // Larger ones are not lists of images.
  constexpr std::uintmax_t kLargest = 64 << 20;
  if (fs::file_size(file, ignored) > kLargest) {
    return false;
  }
  try {
    const std::string image = ReadTimesFile(file).rows.front().image;
    return !image.empty() && (fs::is_regular_file(root / image, ignored) ||
                              fs::is_regular_file(folders[0] / image, ignored));
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::array<std::optional<fs::path>, 3> FindTimesFiles(const fs::path& root,
                                                      const std::array<fs::path, 2>& folders) {
  std::array<std::optional<fs::path>, 3> found;
  const auto take = [](std::optional<fs::path>& place, const fs::path& file) {
    if (!place) {
      place = file;
    }
  };
  if (folders[0] != folders[1]) {
    for (std::size_t side = 0; side < 2; ++side) {
      for (const fs::path& folder : {folders[side], FolderBelow(root, folders[side])}) {
        for (const fs::path& file : TextFiles(folder)) {
          if (IsTimesName(LowerStem(file)) || LowerStem(file) == "data") {
            take(found[side], file);
          }
        }
      }
    }
  }
  for (const fs::path& file : TextFiles(root)) {
    const std::string stem = LowerStem(file);
    std::string ignored;
    const std::optional<std::size_t> side = SideOfName(stem, ignored);
    const auto is_camera = [&](std::size_t camera) {
      return stem == LowerStem(FolderBelow(root, folders[camera]).filename());
    };
    if (folders[0] != folders[1] && (is_camera(0) || is_camera(1))) {
      take(found[is_camera(0) ? 0 : 1], file);
    } else if (IsTimesName(stem)) {
      take(found[side.value_or(2)], file);
    }
  }
  if (!found[0] && !found[1] && !found[2]) {
    const std::vector<fs::path> files = TextFiles(root);
    const auto file = std::find_if(files.begin(), files.end(), [&](const fs::path& path) {
      return NamesImages(path, root, folders);
    });
    found[2] = file == files.end() ? std::nullopt : std::optional(*file);
  }
  return found;
}

}  // namespace gluevo::vo
