#include "gluevo/vo/io/image_file.h"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<unsigned char>;

class ImageFileTest : public testing::Test {
 protected:
  fs::path Path(const std::string& name) const { return folder_.path() / name; }

  void Write(const std::string& name, const Bytes& bytes) const {
    fs::create_directories(Path(name).parent_path());
    std::ofstream(Path(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  }
  /// An image of noise, wider than high, darker on the left.
  static cv::Mat Noise() {
    cv::Mat image(24, 40, CV_8UC1);
    cv::theRNG().state = 7;
    cv::randu(image, 0, 200);
    image.colRange(0, 8) = 5;
    return image;
  }
  static Bytes Encoded(const std::string& ending) {
    Bytes bytes;
    cv::Mat image = Noise();
    if (ending == ".ppm") {
      cv::merge(std::vector<cv::Mat>{image, image, image}, image);
    }
    cv::imencode(ending, image, bytes);
    return bytes;
  }
  std::string ErrorOf(const std::string& name) const {
    try {
      ReadGrayImage(Path(name));
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }

 private:
  TemporaryFolder folder_;
};

// An EXIF directory with nothing but an orientation, 6: to be turned by 90 degrees.
Bytes Exif() {
  return {'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 0x12, 1, 3, 0, 1, 0, 0, 0, 6, 0, 0, 0, 0, 0, 0, 0};
}

Bytes JpegWith(const Bytes& exif, const Bytes& jpeg) {
  Bytes bytes = {0xFF, 0xD8, 0xFF, 0xE1, 0, static_cast<unsigned char>(exif.size() + 8),
                 'E',  'x',  'i',  'f',  0, 0};
  bytes.insert(bytes.end(), exif.begin(), exif.end());
  bytes.insert(bytes.end(), jpeg.begin() + 2, jpeg.end());
  return bytes;
}

TEST_F(ImageFileTest, ReadsAllFormatsAndRefusesThoseThatAreCutOff) {
  for (const std::string ending :
       {".png", ".jpg", ".JPEG", ".pgm", ".ppm", ".bmp", ".tif", ".TIFF", ".webp"}) {
    SCOPED_TRACE(ending);
    const Bytes whole = Encoded(ending);
    Write("image" + ending, whole);
    ASSERT_TRUE(HasImageEnding("image" + ending));
    const GrayImage image = ReadGrayImage(Path("image" + ending));
    EXPECT_EQ(image.pixels.size(), cv::Size(40, 24));
    EXPECT_EQ(image.orientation, 1);
    for (const std::size_t percent : {2U, 30U, 60U, 90U}) {
      const auto end = static_cast<std::ptrdiff_t>(whole.size() * percent / 100);
      Write("cut" + ending, Bytes(whole.begin(), whole.begin() + end));
      EXPECT_NE(ErrorOf("cut" + ending).find("cut" + ending), std::string::npos) << percent;
    }
  }
  Write("empty.png", {});
  EXPECT_NE(ErrorOf("empty.png").find("the file is empty"), std::string::npos);
  fs::create_symlink(Path("nowhere.png"), Path("link.png"));
  EXPECT_NE(ErrorOf("link.png").find("a link to what is not there"), std::string::npos);
}

// libpng would tell standard error of them, beside the one line of the program.
TEST_F(ImageFileTest, BrokenPngChunksAreNoNews) {
  const Bytes whole = Encoded(".png");
  const auto find = [&](const std::string& name) {
    return std::search(whole.begin(), whole.end(), name.begin(), name.end()) - whole.begin();
  };
  Bytes flipped = whole;
  flipped[static_cast<std::size_t>(find("IDAT")) + 9] ^= 0x10U;
  Write("flipped.png", flipped);
  const Bytes note = {0, 0, 0, 4, 't', 'I', 'M', 'E', 1, 2, 3, 4, 0, 0, 0, 0};
  Bytes noted = whole;
  noted.insert(noted.begin() + find("IDAT") - 4, note.begin(), note.end());
  Write("noted.png", noted);
  Write("whole.png", whole);
  testing::internal::CaptureStderr();
  EXPECT_NE(ErrorOf("flipped.png").find("flipped.png: not an image, or cut off"),
            std::string::npos);
  const cv::Mat image = ReadGrayImage(Path("noted.png")).pixels;
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(cv::norm(image, ReadGrayImage(Path("whole.png")).pixels, cv::NORM_L1), 0.0);
}

// The end of a thumbnail, which is a JPEG file inside of one, is not that of the image.
TEST_F(ImageFileTest, AThumbnailsEndIsNotTheImages) {
  Bytes exif = Exif();
  exif.insert(exif.end(), {0xFF, 0xD8, 0xFF, 0xD9});
  Bytes jpeg = JpegWith(exif, Encoded(".jpg"));
  Write("whole.jpg", jpeg);
  EXPECT_EQ(ErrorOf("whole.jpg"), "no error");
  jpeg.resize(jpeg.size() - 20);
  Write("cut.jpg", jpeg);
  EXPECT_NE(ErrorOf("cut.jpg").find("cut off"), std::string::npos);
}

TEST_F(ImageFileTest, NeverTurnsAnImageAndTellsThatItShouldBe) {
  Write("turned.jpg", JpegWith(Exif(), Encoded(".jpg")));
  const GrayImage jpeg = ReadGrayImage(Path("turned.jpg"));
  EXPECT_EQ(jpeg.pixels.size(), cv::Size(40, 24));
  EXPECT_EQ(jpeg.orientation, 6);
  EXPECT_EQ(ImageOrientation(Path("turned.jpg")), 6);

  // A TIFF file of one uncompressed strip: width, height, bits, compression, gray, strip, its rows
  // and size, and the orientation, which the decoder would heed.
  Bytes tiff = {'I', 'I', 42, 0, 8, 0, 0, 0, 9, 0};
  const auto entry = [&](unsigned tag, unsigned value) {
    for (const unsigned part : {tag, 4U, 1U, 0U, value, 0U}) {
      tiff.push_back(static_cast<unsigned char>(part & 255U));
      tiff.push_back(static_cast<unsigned char>(part >> 8U));
    }
  };
  const unsigned strip = 10 + 9 * 12 + 4;
  for (const auto& [tag, value] : std::vector<std::pair<unsigned, unsigned>>{{256, 3},
                                                                             {257, 2},
                                                                             {258, 8},
                                                                             {259, 1},
                                                                             {262, 1},
                                                                             {273, strip},
                                                                             {274, 6},
                                                                             {278, 2},
                                                                             {279, 6}}) {
    entry(tag, value);
    tiff[tiff.size() - 10] = tag == 256 || tag == 257 || tag >= 278 || tag == 273 ? 4 : 3;
  }
  tiff.insert(tiff.end(), {0, 0, 0, 0, 1, 2, 3, 4, 5, 6});
  Write("turned.tif", tiff);
  const GrayImage image = ReadGrayImage(Path("turned.tif"));
  ASSERT_EQ(image.pixels.size(), cv::Size(3, 2));
  EXPECT_EQ(image.pixels.at<unsigned char>(0, 2), 3);
  EXPECT_EQ(image.pixels.at<unsigned char>(1, 0), 4);
  EXPECT_EQ(image.orientation, 6);
}

TEST_F(ImageFileTest, FindsTheBitsThat16BitFilesUse) {
  const auto write = [&](const std::string& name, int value, int type = CV_16UC1) {
    cv::imwrite(Path(name).string(), cv::Mat(24, 40, type, cv::Scalar::all(value)));
    return Path(name);
  };
  EXPECT_EQ(GrayBits({write("8.png", 255, CV_8UC1)}), 16);
  EXPECT_EQ(GrayBits({write("a.png", 900), write("b.png", 20)}), 10);
  EXPECT_EQ(GrayBits({write("c.png", 900), write("d.png", 1024)}), 12);
  EXPECT_EQ(GrayBits({write("e.tif", 16383)}), 14);
  EXPECT_EQ(GrayBits({write("f.pgm", 200)}), 8);
  EXPECT_EQ(GrayBits({write("g.png", 40000)}), 16);
  EXPECT_EQ(GrayBits({Path("missing.png"), Path("a.png")}), 16);
  EXPECT_EQ(GrayBits({}), 16);
  EXPECT_EQ(ReadGrayImage(Path("a.png"), 10).pixels.at<unsigned char>(0, 0), 225);
  EXPECT_EQ(ReadGrayImage(Path("d.png"), 10).pixels.at<unsigned char>(0, 0), 255);
  EXPECT_EQ(ReadGrayImage(Path("g.png")).pixels.at<unsigned char>(0, 0), 156);
  EXPECT_EQ(ReadGrayImage(Path("8.png"), 10).pixels.at<unsigned char>(0, 0), 255);
}

// A file of this kind fails when it is read, as one on a bad sector does.
TEST_F(ImageFileTest, AFileWhoseBytesCannotBeReadIsNamed) {
  const fs::path image = Path("bad.png");
  fs::create_symlink("/proc/self/mem", image);
  try {
    ReadGrayImage(image);
    FAIL() << "no Error";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()), image.string() + ": cannot be read: Input/output error");
  }
  EXPECT_EQ(ImageOrientation(image), 1);
}

TEST_F(ImageFileTest, ListsFoldersWithLinksAndWithoutHiddenFiles) {
  const Bytes png = Encoded(".png");
  Write("set/b.PNG", png);
  Write("set/sub/a.jpg", png);
  Write("set/._b.PNG", {0});
  Write("set/.git/c.png", png);
  Write("set/notes.txt", {});
  Write("other/d.png", png);
  fs::create_symlink(Path("other"), Path("set/linked"));
  fs::create_symlink(Path("other/d.png"), Path("set/e.png"));
  fs::create_symlink(Path("set"), Path("set/sub/above"));  // Back again: not endlessly.
  EXPECT_EQ(ListImages(Path("set")), (std::vector<fs::path>{Path("set/b.PNG"), Path("set/e.png")}));
  EXPECT_EQ(ListImagesBelow(Path("set")),
            (std::vector<fs::path>{Path("set/b.PNG"), Path("set/e.png"), Path("set/linked/d.png"),
                                   Path("set/sub/a.jpg")}));
  EXPECT_THROW(ListImagesBelow(Path("nowhere")), Error);
  fs::create_directories(Path("empty"));
  EXPECT_NE(NoImagesMessage(Path("empty")).find("empty: no images in it: the folder is empty"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::vo
