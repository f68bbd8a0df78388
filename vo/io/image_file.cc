#include "gluevo/vo/io/image_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "foreign_input.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/whole_file.h"
#include "image_bytes.h"
#include "png_chunks.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

ImageBytes ReadBytes(const fs::path& file) {
  std::error_code ignored;
  if (fs::is_directory(file, ignored)) {
    throw Error(file.string() + ": a folder, expected an image");
  }
  if (!fs::is_regular_file(file, ignored)) {
    throw Error(file.string() + (fs::exists(file, ignored) ? ": " + WhyNoFile(file)
                                 : fs::is_symlink(file, ignored)
                                     ? ": no such image: a link to what is not there"
                                     : ": no such image"));
  }
  const std::string bytes = ReadWholeFile(file);
  return {bytes.begin(), bytes.end()};
}

// Nothing where the decoder fails. It turns TIFF images by itself, whatever it is told.
cv::Mat Decode(ImageBytes bytes, const std::optional<OrientationTag>& orientation, int depth) {
  if (orientation) {
    bytes[orientation->offset] = orientation->little_endian ? 1 : 0;
    bytes[orientation->offset + 1] = orientation->little_endian ? 0 : 1;
  }
  if (IsPng(bytes)) {
    bytes = SoundPng(std::move(bytes));
    if (bytes.empty()) {
      return {};
    }
  }
  try {
    return cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION | depth);
  } catch (const cv::Exception&) {
    return {};
  }
}

cv::Mat UpperBits(const cv::Mat& image, int gray_bits) {
  const int shift = std::max(gray_bits - 8, 0);
  cv::Mat gray(image.size(), CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    const auto* const from = image.ptr<uint16_t>(y);
    auto* const to = gray.ptr<unsigned char>(y);
    std::transform(from, from + image.cols, to, [&](uint16_t value) {
      return static_cast<unsigned char>(std::min(value >> shift, 255));
    });
  }
  return gray;
}

// The largest value of a 16-bit image; nothing for other files and those that cannot be read.
std::optional<double> LargestValue(const fs::path& file) {
  try {
    const cv::Mat image = Decode(ReadBytes(file), std::nullopt, cv::IMREAD_ANYDEPTH);
    if (image.type() == CV_16UC1) {
      double largest = 0.0;
      cv::minMaxLoc(image, nullptr, &largest);
      return largest;
    }
  } catch (const Error&) {
    return std::nullopt;
  }
  return std::nullopt;
}

ImageBytes ReadHead(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  ImageBytes head(4096);
  stream.read(reinterpret_cast<char*>(head.data()), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

}  // namespace

int GrayBits(const std::vector<fs::path>& images) {
  constexpr std::size_t kSamples = 32;
  constexpr int kAllBits = 16;
  const std::size_t samples = std::min(kSamples, images.size());
  double largest = 0.0;
  for (std::size_t i = 0; i < samples; ++i) {
    const fs::path& image = images[samples == 1 ? 0 : i * (images.size() - 1) / (samples - 1)];
    if (!MayHaveMoreThanEightBits(ReadHead(image))) {
      return kAllBits;
    }
    largest = std::max(largest, LargestValue(image).value_or(0.0));
  }
  for (const int bits : {8, 10, 12, 14}) {
    if (largest > 0.0 && largest < static_cast<double>(1 << bits)) {
      return bits;
    }
  }
  return kAllBits;
}

GrayImage ReadGrayImage(const fs::path& file, int gray_bits) {
  const ImageBytes bytes = ReadBytes(file);
  if (bytes.empty()) {
    throw Error(file.string() + ": not an image: the file is empty");
  }
  const std::optional<OrientationTag> orientation = FindOrientation(bytes);
  GrayImage image;
  image.orientation = orientation ? orientation->value : 1;
  if (!IsCutOffJpeg(bytes)) {
    constexpr int kEightBits = 0;
    image.pixels = Decode(bytes, orientation, gray_bits < 16 ? cv::IMREAD_ANYDEPTH : kEightBits);
  }
  if (image.pixels.type() == CV_16UC1 && !image.pixels.empty()) {
    image.pixels = UpperBits(image.pixels, gray_bits);
  }
  if (image.pixels.empty() || image.pixels.type() != CV_8UC1) {
    const std::string what = WhatBytesAre(
        {reinterpret_cast<const char*>(bytes.data()), std::min<std::size_t>(bytes.size(), 512)});
    throw Error(file.string() + ": not an image" +
                (what.empty() || what == "an image" ? ", or cut off" : ": " + what));
  }
  return image;
}

int ImageOrientation(const fs::path& file) {
  try {
    const std::optional<OrientationTag> orientation = FindOrientation(ReadBytes(file));
    return orientation ? orientation->value : 1;
  } catch (const Error&) {
    return 1;
  }
}

}  // namespace gluevo::vo
