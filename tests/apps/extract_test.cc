// gluevo extract and gluevo match, and what hloc would read of their files.

#include <gtest/gtest.h>

#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <random>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

// How hloc finds and interprets what is in such files: names of images are the groups that hold
// datasets, a pair's group is NAME0/NAME1 with '-' for slashes, image_size sizes an empty image,
// descriptors go to its matchers by their columns.
constexpr const char* kReader = R"(
import sys
import h5py
import numpy as np

features, matches, name0, name1 = sys.argv[1:]
with h5py.File(features, 'r', libver='latest') as file:
    names = set()
    file.visititems(lambda _, node: names.add(node.parent.name.strip('/'))
                    if isinstance(node, h5py.Dataset) else None)
    print(' '.join(sorted(names)))
    counts = []
    for name in (name0, name1):
        group = file[name]
        keypoints = group['keypoints'].__array__()
        counts.append(len(keypoints))
        assert keypoints.dtype.kind == 'f' and keypoints.shape[1] == 2
        assert group['scores'].shape == (len(keypoints),)
        descriptors = group['descriptors'].__array__()
        assert descriptors.shape == (256, len(keypoints))
        assert np.allclose(np.linalg.norm(descriptors, axis=0), 1.0, atol=1e-4)
        empty = np.empty((1,) + tuple(group['image_size'])[::-1])
        assert empty.shape == (1, 96, 128), empty.shape
        assert keypoints[:, 0].max() < 128 and keypoints[:, 1].max() < 96
with h5py.File(matches, 'r', libver='latest') as file:
    group = file['/'.join(name.replace('/', '-') for name in (name0, name1))]
    found = group['matches0'].__array__()
    scores = group['matching_scores0'].__array__()
    assert found.dtype.kind == 'i' and found.shape == scores.shape == (counts[0],)
    kept = np.where(found != -1)[0]
    assert len(kept) > 10 and found[kept].max() < counts[1]
    assert (scores[kept] > 0).all() and (scores[found == -1] == 0).all()
    print(len(kept))
)";

class ExtractTest : public CommandTest {
 protected:
  // Two views of a random texture in a folder below the images' one.
  fs::path MakeImages() const {
    const fs::path root = Path("images");
    fs::create_directories(root / "left");
    fs::create_directories(root / "right");
    std::mt19937 generator(5);
    cv::Mat texture(96, 140, CV_8UC1);
    for (int y = 0; y < texture.rows; ++y) {
      for (int x = 0; x < texture.cols; ++x) {
        texture.at<uchar>(y, x) = y % 4 == 0 && x % 4 == 0
                                      ? static_cast<uchar>(generator() % 256)
                                      : texture.at<uchar>(y / 4 * 4, x / 4 * 4);
      }
    }
    cv::imwrite((root / "left" / "0.png").string(), texture(cv::Rect(0, 0, 128, 96)));
    cv::imwrite((root / "right" / "0.png").string(), texture(cv::Rect(6, 0, 128, 96)));
    return root;
  }
};

TEST_F(ExtractTest, HlocReadsWhatIsWritten) {
  if (std::system("/usr/bin/python3 -c 'import h5py' >/dev/null 2>&1") != 0) {
    GTEST_SKIP() << "python3-h5py is not installed";
  }
  const fs::path images = MakeImages();
  const Outcome extract = Run("extract " + images.string() + " -o " + Path("features.h5"));
  ASSERT_EQ(extract.exit_code, 0) << extract.error;
  Write("pairs.txt", "left/0.png right/0.png\n");
  const Outcome match = Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") +
                            " -o " + Path("matches.h5"));
  ASSERT_EQ(match.exit_code, 0) << match.error;
  const std::string command = "/usr/bin/python3 " + Write("read.py", kReader) + " " +
                              Path("features.h5") + " " + Path("matches.h5") +
                              " left/0.png right/0.png >" + Path("read") + " 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << Contents(Path("read"));
  EXPECT_EQ(Contents(Path("read")).substr(0, 22), "left/0.png right/0.png")
      << Contents(Path("read"));
}

TEST_F(ExtractTest, AMissingImageOfAPairIsNamedAndNothingIsLeft) {
  const fs::path images = MakeImages();
  ASSERT_EQ(Run("extract " + images.string() + " -o " + Path("features.h5")).exit_code, 0);
  Write("pairs.txt", "left/0.png left/1.png\n");
  const Outcome match = Run("match " + Path("features.h5") + " --pairs " + Path("pairs.txt") +
                            " -o " + Path("matches.h5"));
  EXPECT_EQ(match.exit_code, 1);
  EXPECT_NE(match.error.find("left/1.png"), std::string::npos) << match.error;
  EXPECT_EQ(Files(), 3U);  // images, features.h5, pairs.txt
}

}  // namespace
}  // namespace gluevo::apps
