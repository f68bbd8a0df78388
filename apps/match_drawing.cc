#include "match_drawing.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/nn/option_error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"

namespace gluevo::apps {
namespace {

// By which a drawing is known again, where its format has a place for it.
constexpr std::string_view kMark = "gluevo match";

std::string BigEndian(uint64_t value) {
  std::string bytes;
  for (const int shift : {24, 16, 8, 0}) {
    bytes += static_cast<char>((value >> shift) & 0xffU);
  }
  return bytes;
}

// Puts the mark behind a PNG file's header, as the software that made it (PNG
// specification, 11.3.3: a text chunk). Other files stay as they are.
void AddMark(std::vector<uchar>& bytes) {
  constexpr std::string_view kPng = "\x89PNG";
  constexpr std::ptrdiff_t kAfterHeader = 33;
  if (bytes.size() < kAfterHeader || !std::equal(kPng.begin(), kPng.end(), bytes.begin(),
                                                 [](char a, uchar b) { return uchar(a) == b; })) {
    return;
  }
  std::string chunk = "tEXtSoftware";
  chunk.append(1, '\0').append(kMark);
  const uint64_t checksum =
      crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(chunk.size()));
  constexpr std::size_t kName = 4;
  const std::string whole = BigEndian(chunk.size() - kName) + chunk + BigEndian(checksum);
  bytes.insert(bytes.begin() + kAfterHeader, whole.begin(), whole.end());
}

}  // namespace

void CheckPlaceForDrawing(const std::filesystem::path& path) {
  if (!cv::haveImageWriter(path.string())) {
    throw OptionError(path.string() + ": no image format with this ending (--draw), expected .png");
  }
  nn::CheckReplacesOnly(path, kMark, "a drawing of gluevo match in a PNG file");
  nn::CheckPlaceForFile(path);
}

void DrawMatches(const std::filesystem::path& path, const cv::Mat& image0, const cv::Mat& image1,
                 const nn::Features& features0, const nn::Features& features1,
                 const nn::Matches& matches) {
  cv::Mat canvas(std::max(image0.rows, image1.rows), image0.cols + image1.cols, CV_8UC3,
                 cv::Scalar::all(0));
  cv::cvtColor(image0, canvas(cv::Rect(0, 0, image0.cols, image0.rows)), cv::COLOR_GRAY2BGR);
  cv::cvtColor(image1, canvas(cv::Rect(image0.cols, 0, image1.cols, image1.rows)),
               cv::COLOR_GRAY2BGR);
  for (int i = 0; i < features0.size(); ++i) {
    const int match = matches.matches0[i];
    if (match >= 0) {
      const cv::Point2f from(features0.keypoints(i, 0), features0.keypoints(i, 1));
      const cv::Point2f to(features1.keypoints(match, 0) + static_cast<float>(image0.cols),
                           features1.keypoints(match, 1));
      const double sure = matches.scores0[i];
      cv::line(canvas, from, to, cv::Scalar(0, 255.0 * sure, 255.0 * (1.0 - sure)), 1, cv::LINE_AA);
    }
  }
  std::vector<uchar> bytes;
  cv::imencode(path.extension().string(), canvas, bytes);
  AddMark(bytes);
  nn::WriteWholeFile(path, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
}

}  // namespace gluevo::apps
