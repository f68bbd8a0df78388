// What lies in a folder that is no data set.

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "checks.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> Images(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (!hidden && entry.is_regular_file(ignored) && cv::haveImageReader(entry.path().string())) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::optional<LooseImages> FindLooseImages(const fs::path& root) {
  constexpr const char* kNames[][2] = {{"mav0/cam0/data", "mav0/cam1/data"},
                                       {"cam0/data", "cam1/data"},
                                       {"left", "right"},
                                       {"cam0", "cam1"},
                                       {"image_0", "image_1"},
                                       {"image_2", "image_3"},
                                       {"image_00/data", "image_01/data"},
                                       {"image_02/data", "image_03/data"},
                                       {"image_00/data_rect", "image_01/data_rect"},
                                       {"image_00", "image_01"}};
  for (const auto& [left, right] : kNames) {
    if (fs::is_directory(root / left) && fs::is_directory(root / right)) {
      LooseImages images = {{Images(root / left), Images(root / right)}};
      if (!images.files[0].empty() || !images.files[1].empty()) {
        return images;
      }
    }
  }
  return std::nullopt;
}

cv::Mat ReadLooseImage(const fs::path& file) {
  try {
    cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    return image.type() == CV_8UC1 ? image : cv::Mat();
  } catch (const cv::Exception&) {
    return {};
  }
}

}  // namespace gluevo::vo
