#include "image_files.h"

#include <algorithm>
#include <cctype>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "gluevo/nn/error.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

bool IsImage(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".pgm", ".ppm",
                                         ".bmp", ".tif", ".tiff", ".webp"};
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

}  // namespace

std::vector<fs::path> ListImagesBelow(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw Error(folder.string() + ": no such folder");
  }
  std::vector<fs::path> images;
  for (const fs::directory_entry& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::follow_directory_symlink)) {
    if (entry.is_regular_file() && IsImage(entry.path())) {
      images.push_back(entry.path());
    }
  }
  if (images.empty()) {
    throw Error(folder.string() + ": no images in it or below it");
  }
  std::sort(images.begin(), images.end());
  return images;
}

cv::Mat ReadGrayImage(const fs::path& file) {
  if (!fs::is_regular_file(file)) {
    throw Error(file.string() + ": no such image");
  }
  cv::Mat image;
  try {
    image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) {
    throw Error(file.string() + ": not an image that can be read");
  }
  return image;
}

}  // namespace gluevo::apps
