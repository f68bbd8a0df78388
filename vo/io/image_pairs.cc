#include "image_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "gluevo/nn/error.h"
#include "gluevo/vo/core/steps.h"
#include "stamp_unit.h"

namespace gluevo::vo {
namespace {

using KeyedImages = std::vector<KeyedImage>;

void CheckOnce(const KeyedImages& images, const std::string& key_name) {
  const auto twice =
      std::adjacent_find(images.begin(), images.end(),
                         [](const KeyedImage& a, const KeyedImage& b) { return a.key == b.key; });
  if (twice != images.end()) {
    throw Error((twice + 1)->path.string() + ": has the same " + key_name + " as " +
                twice->path.string());
  }
}

// Of images in the order of keys, none of them the same; the earlier one where two are as near.
std::optional<std::size_t> Nearest(const KeyedImages& images, int64_t key) {
  if (images.empty()) {
    return std::nullopt;
  }
  const auto after =
      std::lower_bound(images.begin(), images.end(), key,
                       [](const KeyedImage& image, int64_t value) { return image.key < value; });
  const auto index = static_cast<std::size_t>(after - images.begin());
  if (after == images.end()) {
    return index - 1;
  }
  return index > 0 && key - images[index - 1].key <= after->key - key ? index - 1 : index;
}

std::string Count(std::size_t count, std::size_t all, const char* side) {
  return std::to_string(count) + " of " + std::to_string(all) + " " + side;
}

// As many images of both cameras, of which one counts from a later number: paired by numbers, but
// perhaps one that counts from 0 and one from 1.
std::string HowNumbered(const ImagePairs& pairs) {
  const auto& [left, right] = pairs.alone;
  if (left.empty() || left.size() != right.size() || pairs.pairs.empty()) {
    return "";
  }
  const int64_t first = pairs.pairs.front().images[0].key;
  const int64_t last = pairs.pairs.back().images[0].key;
  const bool left_is_earlier = left.back().key < first && right.front().key > last;
  const bool right_is_earlier = right.back().key < first && left.front().key > last;
  if (!left_is_earlier && !right_is_earlier) {
    return "";
  }
  const int64_t left_first = left_is_earlier ? left.front().key : first;
  const int64_t right_first = left_is_earlier ? first : right.front().key;
  return "; left images are numbered from " + std::to_string(left_first) + ", right ones from " +
         std::to_string(right_first) +
         ", as many of each: equal numbers are taken as pairs; where the first ones of both belong "
         "together, number them alike";
}

}  // namespace

ImagePairs PairImages(const std::array<KeyedImages, 2>& images, int64_t tolerance,
                      const std::string& key_name) {
  ImagePairs result;
  result.tolerance = tolerance;
  std::array<std::vector<bool>, 2> paired;
  for (std::size_t side = 0; side < 2; ++side) {
    CheckOnce(images[side], key_name);
    result.all[side] = images[side].size();
    paired[side].resize(images[side].size());
  }
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    const KeyedImage& left = images[0][i];
    const std::optional<std::size_t> j = Nearest(images[1], left.key);
    if (j && std::abs(images[1][*j].key - left.key) <= tolerance &&
        Nearest(images[0], images[1][*j].key) == i) {
      result.pairs.push_back({{left, images[1][*j]}});
      paired[0][i] = true;
      paired[1][*j] = true;
    }
  }
  std::vector<int64_t> apart;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < images[side].size(); ++i) {
      if (paired[side][i]) {
        continue;
      }
      const KeyedImage& image = images[side][i];
      result.alone[side].push_back(image);
      if (const auto nearest = Nearest(images[1 - side], image.key)) {
        apart.push_back(std::abs(images[1 - side][*nearest].key - image.key));
      }
    }
  }
  if (!apart.empty()) {
    std::sort(apart.begin(), apart.end());
    result.alone_apart = apart[apart.size() / 2];
  }
  return result;
}

int64_t PairTolerance(const std::array<KeyedImages, 2>& images, const DatasetOptions& options) {
  if (options.pair_tolerance_s) {
    return std::llround(*options.pair_tolerance_s * 1e9);
  }
  std::vector<int64_t> stamps;
  stamps.reserve(images[0].size());
  for (const KeyedImage& image : images[0]) {
    stamps.push_back(image.key);
  }
  constexpr int64_t kOfSingleImages = 1'000'000;
  const int64_t step = MedianStep(std::move(stamps));
  return step > 0 ? step / 10 : kOfSingleImages;
}

void ReportPairs(const ImagePairs& pairs, bool stamped, Dataset& dataset) {
  const std::size_t left = pairs.alone[0].size();
  const std::size_t right = pairs.alone[1].size();
  dataset.images_left_out += static_cast<int>(left + right);
  if (left + right > 0) {
    const KeyedImage& first = left > 0 ? pairs.alone[0].front() : pairs.alone[1].front();
    std::string text = left > 0 && right > 0 ? Count(left, pairs.all[0], "left and ") +
                                                   Count(right, pairs.all[1], "right images")
                       : left > 0 ? Count(left, pairs.all[0], "left images")
                                  : Count(right, pairs.all[1], "right images");
    dataset.warnings.push_back(
        text + (left + right > 1 ? " have no mate and are" : " has no mate and is") +
        " left out (the first is " + first.path.string() + ")" + HowFarApart(pairs, stamped) +
        (stamped ? "" : HowNumbered(pairs)));
  }
  int64_t most = 0;
  for (const ImagePair& pair : pairs.pairs) {
    most = std::max(most, std::abs(pair.images[0].key - pair.images[1].key));
  }
  if (stamped && most > 0) {
    dataset.notes.push_back("the stamps of left and right images differ by up to " +
                            TimeText(most) + "; a frame has the time of its left image");
  }
}

std::string HowFarApart(const ImagePairs& pairs, bool stamped) {
  if (!stamped || !pairs.alone_apart) {
    return "";
  }
  return "; the nearest stamps are " + TimeText(*pairs.alone_apart) + " apart, and at most " +
         TimeText(pairs.tolerance) + " make a pair (--pair-tolerance)";
}

}  // namespace gluevo::vo
