// Two images matched by SuperPoint and SuperGlue: "x0 y0 x1 y1 confidence" a line.
//   match_images A.png B.png

#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "gluevo/nn/error.h"
#include "gluevo/vo/pipeline/networks.h"

namespace {

cv::Mat ReadGray(const char* path) {
  cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
  if (image.empty()) {
    throw gluevo::Error(std::string(path) + ": not an image that can be read");
  }
  return image;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s A.png B.png\n", argv[0]);
    return 2;
  }
  gluevo::nn::ThreadPool pool(0);
  const auto networks = gluevo::vo::LoadNetworks({}, "superpoint", "superglue");
  const auto extractor = gluevo::vo::MakeExtractor(networks, {.max_keypoints = 500}, pool);
  const auto matcher = gluevo::vo::MakeMatcher(networks, pool);

  const gluevo::nn::Features features0 = extractor->Extract(ReadGray(argv[1]));
  const gluevo::nn::Features features1 = extractor->Extract(ReadGray(argv[2]));
  const gluevo::nn::Matches matches = matcher->Match(features0, features1, /*threshold=*/0.2F);
  for (std::size_t i = 0; i < matches.matches0.size(); ++i) {
    if (const int j = matches.matches0[i]; j >= 0) {
      const auto a = features0.keypoints.row(static_cast<Eigen::Index>(i));
      const auto b = features1.keypoints.row(j);
      std::printf("%g %g %g %g %.3f\n", a[0], a[1], b[0], b[1], matches.scores0[i]);
    }
  }
  return 0;
} catch (const gluevo::Error& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 1;
}
