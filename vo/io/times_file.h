#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "image_names.h"

// Files that tell when images were taken: times.txt, timestamps.txt, rgb.txt and their like.
namespace gluevo::vo {

struct TimesFile {
  struct Row {
    int64_t timestamp_ns = 0;
    std::string image;  ///< Its name or number; empty where the row has none.
  };

  std::filesystem::path path;
  std::vector<Row> rows;
  std::string unit;  ///< "microseconds" or the like; empty for seconds and dates.
};

/// Reads a row a line: a stamp; a stamp and an image's name; an image's number or name and a stamp;
/// a date and a time of day. Between the fields are blanks, commas or semicolons; further columns
/// are passed over, and so is a header, which may name the columns and the unit. Throws Error with
/// file and line for anything else, and for rows without names whose times do not increase.
TimesFile ReadTimesFile(const std::filesystem::path& path);

/// The times files of a data set: of both cameras (index 2), or of the left or right one (0, 1).
/// They are looked for in `root`, in the folders of the cameras and in those above these below
/// `root`, by names that hold "time" or "stamp" or that are the camera's; else a file in
/// `root` whose rows name images that are there; nothing where there is none.
std::array<std::optional<std::filesystem::path>, 3> FindTimesFiles(
    const std::filesystem::path& root, const std::array<std::filesystem::path, 2>& folders);

/// The time of each image: by the names of rows where they have some that fit; else row n belongs
/// to image n where there are as many rows as images; else, where images are numbered, to the one
/// of that number, counted from 0 or from `first_number`. Nothing for images without a row. Throws
/// Error naming file and both counts where no row can be told from another.
std::vector<std::optional<int64_t>> TimesOfImages(const TimesFile& times,
                                                  const std::vector<KeyedImage>& images,
                                                  KeyKind kind, int64_t first_number);

}  // namespace gluevo::vo
