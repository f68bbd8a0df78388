#include "image_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

#include "gluevo/nn/error.h"
#include "name_parts.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

// The images of one camera that are named alike, and what their names say.
struct CameraNames {
  std::vector<fs::path> images;
  std::vector<NameParts> parts;
  std::vector<fs::path> others;
  std::optional<NameNumbers> numbers;
};

CameraNames ReadCamera(const std::vector<fs::path>& images) {
  std::map<std::string, std::size_t> counts;
  std::vector<NameParts> parts;
  parts.reserve(images.size());
  for (const fs::path& image : images) {
    parts.push_back(PartsOf(image.stem().string()));
    ++counts[parts.back().skeleton];
  }
  CameraNames camera;
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  if (counts.empty() || 2 * most->second <= images.size()) {
    camera.images = images;
    return camera;
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (parts[i].skeleton == most->first) {
      camera.images.push_back(images[i]);
      camera.parts.push_back(std::move(parts[i]));
    } else {
      camera.others.push_back(images[i]);
    }
  }
  camera.numbers = NumbersOf(camera.parts);
  if (!camera.numbers) {
    camera.images = images;
    camera.others.clear();
  }
  return camera;
}

// Keys in the order of all names of both cameras, without the words that tell the cameras apart.
std::array<std::vector<KeyedImage>, 2> KeysByName(const std::array<CameraNames, 2>& cameras) {
  std::array<std::vector<std::string>, 2> names;
  std::vector<std::string> all;
  for (std::size_t side = 0; side < 2; ++side) {
    for (const fs::path& image : cameras[side].images) {
      std::string rest = image.stem().string();
      const std::string stem = rest;
      SideOfName(stem, rest);
      names[side].push_back(rest);
      all.push_back(rest);
    }
  }
  std::sort(all.begin(), all.end(), &NumbersBefore);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::array<std::vector<KeyedImage>, 2> images;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < names[side].size(); ++i) {
      const auto place = std::lower_bound(all.begin(), all.end(), names[side][i], &NumbersBefore);
      images[side].push_back({place - all.begin(), cameras[side].images[i]});
    }
  }
  return images;
}

std::vector<KeyedImage> KeysByNumber(const CameraNames& camera) {
  std::vector<KeyedImage> images;
  images.reserve(camera.images.size());
  for (std::size_t i = 0; i < camera.images.size(); ++i) {
    images.push_back({camera.numbers->values[i], camera.images[i]});
  }
  return images;
}

// A single image, or two, may not show what the other camera's names show.
void TakeUnitOfTheOther(std::array<CameraNames, 2>& cameras) {
  for (std::size_t side = 0; side < 2; ++side) {
    NameNumbers& mine = *cameras[side].numbers;
    const NameNumbers& other = *cameras[1 - side].numbers;
    if (!mine.unit && other.unit && !other.in_nanoseconds) {
      mine.unit = other.unit;
    }
  }
}

}  // namespace

ImageNames ReadImageNames(const std::array<std::vector<fs::path>, 2>& images) {
  std::array<CameraNames, 2> cameras = {ReadCamera(images[0]), ReadCamera(images[1])};
  ImageNames names;
  for (const CameraNames& camera : cameras) {
    names.others.insert(names.others.end(), camera.others.begin(), camera.others.end());
  }
  if (!cameras[0].numbers || !cameras[1].numbers) {
    names.kind = KeyKind::kNames;
    names.others.clear();
    for (std::size_t side = 0; side < 2; ++side) {
      cameras[side].images = images[side];
    }
    names.images = KeysByName(cameras);
  } else {
    TakeUnitOfTheOther(cameras);
    const std::optional<StampUnit> unit = cameras[0].numbers->unit;
    if (unit.has_value() != cameras[1].numbers->unit.has_value()) {
      const std::size_t stamped = unit ? 0 : 1;
      throw Error(images[stamped].front().string() + ": is named by its time, " +
                  images[1 - stamped].front().string() +
                  " by a number: expected the same for both cameras");
    }
    names.kind = unit ? KeyKind::kStamps : KeyKind::kNumbers;
    for (std::size_t side = 0; side < 2; ++side) {
      names.images[side] = KeysByNumber(cameras[side]);
      if (unit && !cameras[side].numbers->in_nanoseconds) {
        for (KeyedImage& image : names.images[side]) {
          const auto time = InNanoseconds(image.key, *cameras[side].numbers->unit);
          if (!time) {
            throw Error(image.path.string() + ": its name is a time beyond 292 years");
          }
          image.key = *time;
        }
      }
    }
    if (unit) {
      names.unit = cameras[0].numbers->form;
      if (names.unit.empty() && !cameras[0].numbers->in_nanoseconds && *unit != 9) {
        names.unit = UnitName(*unit);
      }
    }
  }
  for (std::vector<KeyedImage>& side : names.images) {
    std::sort(side.begin(), side.end(), [](const KeyedImage& a, const KeyedImage& b) {
      return a.key != b.key ? a.key < b.key : a.path < b.path;
    });
  }
  return names;
}

std::optional<std::size_t> SideOfName(const std::string& name, std::string& rest) {
  const NameWords words = WordsOf(name);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i].text;
    const bool camera = (word == "cam" || word == "camera") && i + 1 < words.size();
    const std::string next = camera ? words[i + 1].text : std::string();
    const bool left = word.find("left") != std::string::npos || word == "l" || next == "0";
    const bool right = word.find("right") != std::string::npos || word == "r" || next == "1";
    if (left != right) {
      const std::size_t last = camera ? i + 1 : i;
      rest =
          name.substr(0, words[i].begin) + name.substr(words[last].begin + words[last].text.size());
      return left ? 0 : 1;
    }
  }
  return std::nullopt;
}

}  // namespace gluevo::vo
