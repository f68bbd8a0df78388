#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <vector>

#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

// As tests/nn/golden.h derives it for whole networks.
constexpr double kNetworkTolerance = 300.0 * 0x1p-24;

class BenchTest : public CommandTest {
 protected:
  static std::string Golden(const std::string& name) {
    return std::string(GLUEVO_SOURCE_DIR) + "/tests/data/" + name;
  }
  // The values of a tensor of a safetensors file of this machine's byte order.
  static std::vector<float> Tensor(const std::string& path, const std::string& name) {
    const std::string bytes = Contents(path);
    uint64_t header_size = 0;
    std::memcpy(&header_size, bytes.data(), sizeof(header_size));
    const auto header = nlohmann::json::parse(bytes.substr(8, header_size));
    const std::size_t begin = header.at(name).at("data_offsets")[0];
    const std::size_t end = header.at(name).at("data_offsets")[1];
    std::vector<float> values((end - begin) / sizeof(float));
    std::memcpy(values.data(), bytes.data() + 8 + header_size + begin, end - begin);
    return values;
  }
  static std::vector<double> Numbers(const std::string& lines) {
    std::istringstream stream(lines);
    std::vector<double> numbers;
    for (double number = 0.0; stream >> number;) {
      numbers.push_back(number);
    }
    EXPECT_TRUE(stream.eof()) << lines;
    return numbers;
  }
  // Relative RMS difference of the tensors of one name in two files: 0 where they are the same.
  static double Difference(const std::string& path, const std::string& expected_path,
                           const std::string& name) {
    const std::vector<float> actual = Tensor(path, name);
    const std::vector<float> expected = Tensor(expected_path, name);
    EXPECT_EQ(actual.size(), expected.size()) << name;
    EXPECT_FALSE(expected.empty()) << name;
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < std::min(actual.size(), expected.size()); ++i) {
      error += std::pow(static_cast<double>(actual[i]) - expected[i], 2);
      norm += std::pow(expected[i], 2);
    }
    return std::sqrt(error / norm);
  }
};

TEST_F(BenchTest, PrintsOneTimeForEachLineOfInput) {
  Write("requests", "\n\n\n");
  const Outcome outcome = Run("bench --size 64x48 --on-request <" + Path("requests"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  const std::vector<double> times = Numbers(outcome.out);
  ASSERT_EQ(times.size(), 3U) << outcome.out;
  for (const double time : times) {
    EXPECT_GT(time, 0.0);
  }
}

TEST_F(BenchTest, ReportsTheSizeOfTheImageItRead) {
  cv::imwrite(Path("image.png"), cv::Mat(40, 72, CV_8UC1, cv::Scalar(100)));
  const Outcome outcome = Run("bench --rounds 1 --json --image " + Path("image.png"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["size"], "72x40");
}

// The operations of the published networks, in units of 1e9; see nn's tests for their count.
TEST_F(BenchTest, ReportsOperationsAndTheirShareOfThePeak) {
  constexpr double kSuperPoint = 2.0 * 84804.0 * 240 * 160 * 1e-9;
  const Outcome superpoint = Run("bench --layers 18 --size 240x160 --rounds 3 --threads 1 --json");
  ASSERT_EQ(superpoint.exit_code, 0) << superpoint.error;
  const auto extract = nlohmann::json::parse(superpoint.out);
  EXPECT_EQ(extract["weights"], "random weights");
  EXPECT_NEAR(extract["gflops"].get<double>() * extract["median_ms"].get<double>() * 1e-3,
              kSuperPoint, 1e-4 * kSuperPoint);

  const auto match = [&](const std::string& options) {
    const Outcome outcome =
        Run("bench --network superglue --keypoints 50 --rounds 3 --json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    return nlohmann::json::parse(outcome.out);
  };
  const auto operations = [](const nlohmann::json& json) {
    return json["gflops"].get<double>() * json["median_ms"].get<double>() * 1e-3;
  };
  const auto published = match("--layers 18");
  const auto two = match("--layers 2 --precision bf16");
  EXPECT_EQ(published["layers"], 18);
  EXPECT_EQ(two["layers"], 2);
  EXPECT_EQ(published["precision"], "float");
  EXPECT_EQ(two["precision"], "bf16");
  constexpr double kLayer = 100 * (4.0 * 256 * 256 + 512.0 * 512 + 512 * 256 + 2 * 256.0 * 50);
  EXPECT_NEAR(operations(published) - operations(two), 2e-9 * 16 * kLayer, 1e-9 * kLayer);
  for (const auto& json : {extract, published, two}) {
    EXPECT_GT(json["peak_gflops"], 0.01);
    EXPECT_GT(json["peak_share"], 0.0);
    EXPECT_LE(json["min_ms"], json["median_ms"]);
  }

  const auto built_in = match("");
  EXPECT_EQ(built_in["weights"], "built-in superglue");
  EXPECT_EQ(built_in["layers"], 6);
}

TEST_F(BenchTest, RefusesLayersThatCannotBe) {
  for (const std::string options :
       {"--layers 0", "--layers 101", "--layers many", "--layers 18 --weights folder",
        "--layers 18 --superglue file", "--rounds 0", "--threads -1", "--keypoints 0"}) {
    const Outcome outcome = Run("bench --network superglue " + options);
    EXPECT_EQ(outcome.exit_code, 2) << options;
    const std::string option = options.substr(0, options.find(' '));
    EXPECT_NE(outcome.error.substr(0, outcome.error.find('\n')).find(option), std::string::npos)
        << outcome.error;
    EXPECT_TRUE(outcome.out.empty()) << outcome.out;
  }
  const Outcome size = Run("bench --layers 18 --size 7x7");
  EXPECT_EQ(size.exit_code, 2);
  EXPECT_NE(size.error.find("--size"), std::string::npos) << size.error;
}

TEST_F(BenchTest, WritesWhatSuperPointComputes) {
  const std::string golden = Golden("golden_superpoint_120x88.safetensors");
  const std::vector<float> pixels = Tensor(golden, "image");
  cv::Mat image(88, 120, CV_8UC1);
  ASSERT_EQ(pixels.size(), image.total());
  std::copy(pixels.begin(), pixels.end(), image.begin<uchar>());
  cv::imwrite(Path("image.png"), image);
  const Outcome outcome =
      Run("bench --rounds 1 --image " + Path("image.png") + " --output " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(Difference(Path("out"), golden, "image"), 0.0);
  EXPECT_LT(Difference(Path("out"), golden, "score_map"), kNetworkTolerance);
  EXPECT_LT(Difference(Path("out"), golden, "descriptor_map"), kNetworkTolerance);
  EXPECT_EQ(Tensor(Path("out"), "keypoints").size(), Tensor(golden, "keypoints").size());
}

TEST_F(BenchTest, WritesWhatSuperGlueComputes) {
  const std::string golden = Golden("golden_superglue_open.safetensors");
  const Outcome outcome = Run("bench --network superglue --rounds 1 --json --features " + golden +
                              " --output " + Path("out"));
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(nlohmann::json::parse(outcome.out)["keypoints"], 61);
  for (const std::string name : {"keypoints1", "descriptors0", "size1", "matches0"}) {
    EXPECT_EQ(Difference(Path("out"), golden, name), 0.0) << name;
  }
  EXPECT_LT(Difference(Path("out"), golden, "log_assignment"), kNetworkTolerance);
}

TEST_F(BenchTest, NamesWhatDoesNotFit) {
  const std::string golden = Golden("golden_superpoint_120x88.safetensors");
  const Outcome features = Run("bench --network superglue --features " + golden);
  EXPECT_EQ(features.exit_code, 1);
  EXPECT_NE(features.error.find("size0"), std::string::npos) << features.error;
  EXPECT_NE(features.error.find("golden_superpoint"), std::string::npos) << features.error;
  EXPECT_EQ(Run("bench --features " + golden).exit_code, 2);
  EXPECT_EQ(Run("bench --network superglue --image a.png").exit_code, 2);
  EXPECT_EQ(Run("bench --on-request --rounds 3").exit_code, 2);
  const Outcome image = Run("bench --image " + Path("absent.png") + " --output " + Path("out"));
  EXPECT_EQ(image.exit_code, 1);
  EXPECT_NE(image.error.find("absent.png"), std::string::npos);
  EXPECT_EQ(Files(), 0U);
}

}  // namespace
}  // namespace gluevo::apps
