// What people name in place of images, calibrations and feature files is told by its name.

#include "foreign_input.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <string>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/calibration.h"
#include "gluevo/vo/io/image_file.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;
using std::string_literals::operator""s;

const std::string kPointer = "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 3\n";
const std::string kPage = "\n<!DOCTYPE html>\n<html><body>Sign in</body></html>\n";

class ForeignInputTest : public testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
    return folder_.path() / name;
  }
  const fs::path& folder() const { return folder_.path(); }
  static void ExpectError(const std::function<void()>& read, const std::string& part) {
    try {
      read();
      ADD_FAILURE() << "no error, expected one with: " << part;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
          << '"' << part << "\" in: " << error.what();
    }
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(ForeignInputTest, IsToldByItsBytesOrItsEnding) {
  EXPECT_EQ(WhatFileIs(Write("a.svo2", "\x89MCAP0")), "a recording of a ZED camera (svo2)");
  EXPECT_EQ(WhatFileIs(Write("a.mcap", "\x89MCAP0")), "a ROS 2 bag (mcap)");
  EXPECT_EQ(WhatFileIs(Write("a.npz", "PK\x03\x04")), "NumPy arrays (npz)");
  EXPECT_EQ(WhatFileIs(Write("a.bin", "PK\x03\x04")), "a zip archive");
  EXPECT_EQ(WhatFileIs(Write("a.txt", "1 2 3")), "a text file");
  EXPECT_EQ(WhatBytesAre("%YAML:1.0\n---\nK1: 3\n"), "");
}

TEST_F(ForeignInputTest, InPlaceOfImages) {
  const auto image = [&](const std::string& bytes) {
    const fs::path file = Write("a.png", bytes);
    return [file] { ReadGrayImage(file); };
  };
  ExpectError(image(kPointer), "a.png: not an image: a pointer of Git LFS (fetch the file");
  ExpectError(image(kPage), "a.png: not an image: a web page");
  ExpectError(image("PK\x03\x04"), "a.png: not an image: a zip archive");
  ExpectError(image("\x89PNG\r\n\x1a\n"), "a.png: not an image, or cut off");
  ExpectError([&] { ReadGrayImage(folder()); }, ": a folder, expected an image");
  ExpectError([&] { ListImagesBelow(Write("v.mp4", "\0\0\0\x18"s + "ftypisom")); },
              "v.mp4: a video, expected a folder of images");
}

TEST_F(ForeignInputTest, InPlaceOfCalibrations) {
  const auto calibration = [&](const std::string& bytes) {
    const fs::path file = Write("c.yaml", bytes);
    return [file] { ReadCalibration({file}, std::nullopt); };
  };
  ExpectError(calibration("\x89PNG\r\n\x1a\n\0\0"s), "c.yaml: not a calibration: an image");
  ExpectError(calibration("\x93NUMPY\x01\0v\0{'descr'"s), "a NumPy array");
  ExpectError(calibration("\x80\x04\x95\x10\0"s), "a pickle of Python");
  ExpectError(calibration("MATLAB 5.0 MAT-file, Platform"), "a MATLAB file");
  ExpectError(calibration("PK\x03\x04\x14\0"s), "a zip archive");
  ExpectError(calibration(kPage), "a web page");
  ExpectError(calibration(kPointer), "a pointer of Git LFS");
  ExpectError(calibration(" \n"), "an empty file");
  ExpectError(calibration("camera: ["), "not YAML");
}

TEST_F(ForeignInputTest, OneCalibrationForTwo) {
  const std::string info =
      "image_width: 32\nimage_height: 24\ncamera_name: left\ndistortion_model: plumb_bob\n"
      "camera_matrix: {rows: 3, cols: 3, data: [20, 0, 16, 0, 20, 12, 0, 0, 1]}\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n"
      "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
      "projection_matrix: {rows: 3, cols: 4, data: [20, 0, 16, 0, 0, 20, 12, 0, 0, 0, 1, 0]}\n";
  const fs::path left = Write("left.yaml", info);
  ExpectError([&] { ReadCalibration({left}, std::nullopt); },
              "right.yaml of the other one: name both files");
  ExpectError(
      [&] {
        ReadCalibration({left, folder() / "." / "left.yaml"}, std::nullopt);
      },
      "the same file twice");
  Write("right.yaml", "something: else\n");
  ExpectError([&] { ReadCalibration({left}, std::nullopt); },
              "right.yaml beside it is not the other one's");
}

}  // namespace
}  // namespace gluevo::vo
