// Which row of a times file is which image's.

#include <algorithm>
#include <map>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"
#include "text_file.h"
#include "times_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::string StemOf(const std::string& image) {
  const fs::path name = fs::path(image).filename();
  return HasImageEnding(name) ? name.stem().string() : name.string();
}

// Whether a listed name has the folder of an image: left/000001.png.
bool IsIn(const std::string& listed, const fs::path& image) {
  const fs::path folder = fs::path(listed).parent_path().filename();
  return !folder.empty() && (folder == image.parent_path().filename() ||
                             folder == image.parent_path().parent_path().filename());
}

bool NamesFolderOf(const TimesFile& times, const std::vector<KeyedImage>& images) {
  return !images.empty() &&
         std::any_of(times.rows.begin(), times.rows.end(), [&](const TimesFile::Row& row) {
           return IsIn(row.image, images.front().path);
         });
}

}  // namespace

std::vector<std::optional<int64_t>> TimesOfImages(const TimesFile& times,
                                                  const std::vector<KeyedImage>& images,
                                                  KeyKind kind, int64_t first_number) {
  std::vector<std::optional<int64_t>> result(images.size());
  std::map<std::string, int64_t> by_name;
  std::map<int64_t, int64_t> by_number;
  const bool of_this_folder = NamesFolderOf(times, images);
  for (const TimesFile::Row& row : times.rows) {
    if (of_this_folder && !IsIn(row.image, images.front().path)) {
      continue;
    }
    const auto [named, is_new] = by_name.insert({StemOf(row.image), row.timestamp_ns});
    if (!is_new && !row.image.empty() && named->second != row.timestamp_ns) {
      throw Error(times.path.string() + ": two times for " + Quoted(row.image) +
                  ", expected one for each image (or the folders of both cameras in the names)");
    }
    if (const std::optional<int64_t> number = ParseInteger(row.image)) {
      by_number[*number] = row.timestamp_ns;
    }
  }
  bool any = false;
  for (std::size_t i = 0; i < images.size() && !times.rows.front().image.empty(); ++i) {
    const auto named = by_name.find(images[i].path.stem().string());
    const auto numbered = by_number.find(images[i].key);
    if (named != by_name.end()) {
      result[i] = named->second;
    } else if (kind == KeyKind::kNumbers && numbered != by_number.end()) {
      result[i] = numbered->second;
    }
    any = any || result[i];
  }
  if (any) {
    return result;
  }
  const auto rows = static_cast<int64_t>(times.rows.size());
  const int64_t last = images.empty() ? 0 : images.back().key;
  const int64_t first_row = last < rows ? 0 : first_number;
  const bool as_many = times.rows.size() == images.size();
  if (!as_many && (kind != KeyKind::kNumbers || last - first_row >= rows)) {
    throw Error(times.path.string() + ": has " + std::to_string(rows) + " times for the " +
                std::to_string(images.size()) + " images of " +
                images.front().path.parent_path().string() + ", expected one for each");
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    const auto row = as_many ? i : static_cast<std::size_t>(images[i].key - first_row);
    result[i] = times.rows[row].timestamp_ns;
  }
  return result;
}

}  // namespace gluevo::vo
