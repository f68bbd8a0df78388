#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"
#include "image_names.h"

// Which images of two cameras belong together.
namespace gluevo::vo {

struct ImagePair {
  std::array<KeyedImage, 2> images;
};

struct ImagePairs {
  std::vector<ImagePair> pairs;                  ///< In the order of the left keys.
  std::array<std::vector<KeyedImage>, 2> alone;  ///< Images without a mate.
  std::array<std::size_t, 2> all = {0, 0};       ///< Images there were.
  int64_t tolerance = 0;
  /// How far the nearest keys of the images without a mate are apart: the middle one of these
  /// distances; nothing where a camera has no images.
  std::optional<int64_t> alone_apart;
};

/// Pairs each image with the nearest of the other camera where each is the other's nearest and
/// their keys differ by at most `tolerance`. Both lists are in the order of keys. Throws Error
/// naming both images where two of a camera have the same key, which is called `key_name`
/// ("number", "time").
ImagePairs PairImages(const std::array<std::vector<KeyedImage>, 2>& images, int64_t tolerance,
                      const std::string& key_name);

/// How far the stamps of a pair may be apart, nanoseconds: what the options say, else a tenth of
/// the time from one image to the next (the middle one of these times), 1 ms of single images.
int64_t PairTolerance(const std::array<std::vector<KeyedImage>, 2>& images,
                      const DatasetOptions& options);

/// Counts the images without a mate, and warns of them and of stamps that differ. `stamped`: keys
/// are nanoseconds.
void ReportPairs(const ImagePairs& pairs, bool stamped, Dataset& dataset);

/// "; the nearest stamps are 40 ms apart, and at most 10 ms make a pair (--pair-tolerance)", or
/// nothing where keys are no stamps.
std::string HowFarApart(const ImagePairs& pairs, bool stamped);

}  // namespace gluevo::vo
