// What lies in a folder that is no data set.

#include "checks.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/image_file.h"

namespace gluevo::vo {

namespace fs = std::filesystem;

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
      LooseImages images = {{ListImages(root / left), ListImages(root / right)}};
      if (!images.files[0].empty() || !images.files[1].empty()) {
        return images;
      }
    }
  }
  return std::nullopt;
}

cv::Mat ReadLooseImage(const fs::path& file, int gray_bits) {
  try {
    return ReadGrayImage(file, gray_bits).pixels;
  } catch (const Error&) {
    return {};
  }
}

}  // namespace gluevo::vo
