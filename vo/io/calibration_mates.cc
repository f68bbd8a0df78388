// Which file is the other camera's.

#include <algorithm>
#include <system_error>

#include "calibration_forms.h"
#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// The more particular first: "cam1" is the right one of cam0 and cam1 before the left one of 1
// and 2.
constexpr std::array<const char*, 2> kSides[] = {{"left", "right"},
                                                 {"Left", "Right"},
                                                 {"LEFT", "RIGHT"},
                                                 {"cam0", "cam1"},
                                                 {"camera0", "camera1"},
                                                 {"cam_0", "cam_1"},
                                                 {"camera_0", "camera_1"},
                                                 {"cam1", "cam2"},
                                                 {"camera1", "camera2"},
                                                 {"cam_1", "cam_2"},
                                                 {"camera_1", "camera_2"},
                                                 {"infra1", "infra2"},
                                                 {"_l", "_r"},
                                                 {"_L", "_R"},
                                                 {"0", "1"},
                                                 {"1", "2"}};

// `path` with the last `from` in the file's name, else in its folder's, replaced; empty for none.
fs::path Replaced(const fs::path& path, std::string_view from, std::string_view to) {
  std::string name = path.filename().string();
  if (const std::size_t at = name.rfind(from); at != std::string::npos) {
    return path.parent_path() / name.replace(at, from.size(), to);
  }
  std::string folder = path.parent_path().filename().string();
  if (const std::size_t at = folder.rfind(from); at != std::string::npos) {
    return path.parent_path().parent_path() / folder.replace(at, from.size(), to) / name;
  }
  return {};
}

// "sensor.yaml" lies in a folder, too, which the name does not tell.
fs::path MateOf(const fs::path& path, std::string_view from, std::string_view to) {
  fs::path mate = Replaced(path, from, to);
  return mate.empty() ? Replaced(fs::absolute(path).lexically_normal(), from, to) : mate;
}

}  // namespace

std::vector<MateName> MateNames(const fs::path& path) {
  std::vector<MateName> names;
  for (const auto& [left, right] : kSides) {
    const bool by_digit_alone = std::string_view(left).size() == 1;
    if (fs::path mate = MateOf(path, left, right); !mate.empty()) {
      names.push_back({std::move(mate), true, by_digit_alone});
    }
    if (fs::path mate = MateOf(path, right, left); !mate.empty()) {
      names.push_back({std::move(mate), false, by_digit_alone});
    }
  }
  return names;
}

std::array<CalibrationFile, 2> LeftAndRight(const CalibrationInput& input,
                                            bool (*is)(const CalibrationFile&),
                                            Calibration& calibration) {
  const CalibrationFile& first = input.named.front();
  const std::vector<MateName> mates = MateNames(first.path);
  if (input.named.size() > 1) {
    const CalibrationFile& second = input.named[1];
    if (!second.syntax_error.empty()) {
      throw Error(second.syntax_error);
    }
    if (!is(second)) {
      throw Error(second.path.string() + ": not of the same kind as " + first.path.string() +
                  ", expected that of the other camera");
    }
    // Names that say which is which go before the order; a number at the end of any name does not.
    const fs::path other = fs::absolute(second.path).lexically_normal();
    const auto named = std::find_if(mates.begin(), mates.end(), [&](const MateName& mate) {
      return !mate.by_digit_alone && fs::absolute(mate.path).lexically_normal() == other;
    });
    const bool exchanged = named != mates.end() && !named->named_is_left;
    return exchanged ? std::array{second, first} : std::array{first, second};
  }
  for (const MateName& mate : mates) {
    auto file = input.open(mate.path);
    if (file && is(*file)) {
      calibration.files.push_back(file->path);
      return mate.named_is_left ? std::array{first, *file} : std::array{*file, first};
    }
  }
  std::error_code ignored;
  const bool is_there = !mates.empty() && fs::exists(mates.front().path, ignored);
  throw Error(first.path.string() + ": of one camera, and " +
              (is_there        ? mates.front().path.string() + " beside it is not the other one's"
               : mates.empty() ? "no file of the other one is beside it"
                               : "no " + mates.front().path.string() + " of the other one") +
              ": name both files");
}

}  // namespace gluevo::vo
