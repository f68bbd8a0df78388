#pragma once

#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

// The image files that all commands take, and how they are read. Hidden files (names that begin
// with a dot) are no images; links are followed, to files and to folders.
namespace gluevo::vo {

/// Whether a name ends as an image file's: .png, .jpg, .jpeg, .jpe, .jfif, .pgm, .ppm, .pnm, .pbm,
/// .bmp, .dib, .tif, .tiff, .webp or .jp2, in upper or lower case.
bool HasImageEnding(const std::filesystem::path& name);

/// The image files of a folder in the order of their names; a link whose target is missing is
/// listed, so that whoever reads it can name it. Throws Error where the folder cannot be listed.
std::vector<std::filesystem::path> ListImages(const std::filesystem::path& folder);

/// The image files of a folder and of those below it, in the order of their paths. Throws Error
/// where there are none.
std::vector<std::filesystem::path> ListImagesBelow(const std::filesystem::path& folder);

/// "FOLDER: no images in it", and what is there instead.
std::string NoImagesMessage(const std::filesystem::path& folder);

struct GrayImage {
  cv::Mat pixels;  ///< CV_8UC1, as stored: EXIF's and TIFF's orientation is not applied.
  /// The orientation that the file asks for, 1 to 8. Viewers turn or mirror all but 1.
  int orientation = 1;
};

/// How many bits the gray values of 16-bit files use: 8, 10, 12, 14 or 16, the fewest that hold all
/// values of up to 32 of the images, evenly chosen; 16 where files have 8 bits a value or cannot be
/// read. Cameras of 10 and 12 bits are often stored so.
int GrayBits(const std::vector<std::filesystem::path>& images);

/// Reads a gray or colour image. Of 16-bit values the upper eight of the lowest `gray_bits` bits
/// are taken, values beyond them being 255; other files are not affected. Throws Error naming the
/// file where it is missing, empty, cut off or not an image.
GrayImage ReadGrayImage(const std::filesystem::path& file, int gray_bits = 16);

/// The orientation that a file asks for, 1 where it asks for none or cannot be read.
int ImageOrientation(const std::filesystem::path& file);

}  // namespace gluevo::vo
