#include "plain_images.h"

#include <algorithm>
#include <map>
#include <system_error>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"
#include "image_names.h"
#include "name_parts.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> Folders(const fs::path& root) {
  std::vector<fs::path> folders;
  std::error_code code;
  std::error_code ignored;
  for (auto entry = fs::directory_iterator(root, code); !code && entry != fs::directory_iterator();
       entry.increment(code)) {
    if (fs::is_directory(entry->path(), ignored) &&
        !entry->path().filename().string().starts_with('.')) {
      folders.push_back(entry->path());
    }
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

struct Candidate {
  int rank = 0;  // The lower, the plainer.
  std::array<fs::path, 2> folders;
};

// What stands before the number of a camera.
bool IsCameraWord(const std::string& word) {
  constexpr const char* kWords[] = {"cam",   "camera", "image",  "images", "img", "im",
                                    "infra", "ir",     "stereo", "mono",   "view"};
  return std::any_of(std::begin(kWords), std::end(kWords),
                     [&](const char* known) { return word == known; });
}

// A folder's name without its side, and which one it is; nothing where it names none. Digits count
// from the rank's first camera.
struct Side {
  std::string rest;
  std::size_t side = 0;
};

std::optional<Side> SideByWord(const std::string& name) {
  Side side;
  const std::optional<std::size_t> found = SideOfName(name, side.rest);
  if (!found) {
    return std::nullopt;
  }
  side.side = *found;
  side.rest = Lowercase(side.rest);
  return side;
}

std::optional<Side> SideByNumber(const std::string& name, int first) {
  const NameWords words = WordsOf(name);
  if (words.size() < 2 || !IsCameraWord(words[0].text)) {
    return std::nullopt;
  }
  const std::string& digits = words[1].text;
  const std::size_t nonzero = std::min(digits.find_first_not_of('0'), digits.size() - 1);
  for (const int side : {0, 1}) {
    if (digits.substr(nonzero) == std::to_string(first + side)) {
      std::string rest;
      for (std::size_t i = 0; i < words.size(); ++i) {
        rest += i == 1 ? std::to_string(digits.size()) + "#" : words[i].text + "_";
      }
      return Side{rest, static_cast<std::size_t>(side)};
    }
  }
  return std::nullopt;
}

template <typename SideOf>
void AddCandidates(const std::vector<fs::path>& folders, int rank, const SideOf& side_of,
                   std::vector<Candidate>& candidates) {
  std::map<std::string, std::array<fs::path, 2>> by_rest;
  for (const fs::path& folder : folders) {
    const std::optional<Side> side = side_of(folder.filename().string());
    if (side && by_rest[side->rest][side->side].empty()) {
      by_rest[side->rest][side->side] = folder;
    }
  }
  for (const auto& [rest, pair] : by_rest) {
    if (!pair[0].empty() && !pair[1].empty()) {
      candidates.push_back({rank, pair});
    }
  }
}

// The folder itself, data in it, or the only one in it that holds images.
fs::path ImagesIn(const fs::path& folder) {
  std::error_code ignored;
  const bool has_data = fs::is_directory(folder / "data", ignored);
  if (has_data && !ListImages(folder / "data").empty()) {
    return folder / "data";
  }
  if (!ListImages(folder).empty()) {
    return folder;
  }
  std::vector<fs::path> holding = Folders(folder);
  std::erase_if(holding, [](const fs::path& inner) { return ListImages(inner).empty(); });
  return holding.size() == 1 ? holding.front() : folder;
}

std::optional<PlainImages> FindPair(const fs::path& root) {
  const std::vector<fs::path> folders = Folders(root);
  std::vector<Candidate> candidates;
  constexpr const char* kUsual[][2] = {
      {"left", "right"}, {"cam0", "cam1"}, {"image_0", "image_1"}, {"image_00", "image_01"}};
  std::error_code ignored;
  for (const auto& [left, right] : kUsual) {
    if (fs::is_directory(root / left, ignored) && fs::is_directory(root / right, ignored)) {
      return PlainImages{{ImagesIn(root / left), ImagesIn(root / right)}, ""};
    }
  }
  AddCandidates(folders, 1, &SideByWord, candidates);
  for (const int first : {0, 1, 2}) {
    AddCandidates(
        folders, 2 + first, [&](const std::string& name) { return SideByNumber(name, first); },
        candidates);
  }
  if (candidates.empty()) {
    return std::nullopt;
  }
  const auto best = std::min_element(
      candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
        const std::size_t first = a.folders[0].filename().string().size();
        const std::size_t second = b.folders[0].filename().string().size();
        return a.rank != b.rank  ? a.rank < b.rank
               : first != second ? first < second
                                 : a.folders[0] < b.folders[0];
      });
  PlainImages found{{ImagesIn(best->folders[0]), ImagesIn(best->folders[1])}, ""};
  // Two folders may be a pair in several ways: 0 and 1 of cameras, sides of a name.
  const bool has_others =
      std::any_of(candidates.begin(), candidates.end(),
                  [&](const Candidate& other) { return other.folders != best->folders; });
  if (has_others) {
    found.note = "taken are the folders " + best->folders[0].filename().string() + " and " +
                 best->folders[1].filename().string() + ", others would do as well";
  }
  return found;
}

std::array<std::vector<fs::path>, 2> SplitBySide(const fs::path& folder) {
  std::array<std::vector<fs::path>, 2> images;
  for (const fs::path& image : ListImages(folder)) {
    std::string ignored;
    if (const auto side = SideOfName(image.stem().string(), ignored)) {
      images[*side].push_back(image);
    }
  }
  return images;
}

}  // namespace

std::optional<PlainImages> FindPlainImages(const fs::path& root) {
  if (std::optional<PlainImages> pair = FindPair(root)) {
    return pair;
  }
  const std::array<std::vector<fs::path>, 2> images = SplitBySide(root);
  if (images[0].empty() || images[1].empty()) {
    return std::nullopt;
  }
  return PlainImages{{root, root}, ""};
}

std::array<std::vector<fs::path>, 2> ListPlainImages(const PlainImages& found) {
  if (found.folders[0] == found.folders[1]) {
    return SplitBySide(found.folders[0]);
  }
  std::array<std::vector<fs::path>, 2> images;
  for (std::size_t side = 0; side < 2; ++side) {
    images[side] = ListImages(found.folders[side]);
    if (images[side].empty()) {
      throw Error(NoImagesMessage(found.folders[side]));
    }
  }
  return images;
}

}  // namespace gluevo::vo
