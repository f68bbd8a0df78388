#include "test_image.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace gluevo::weights_tools {
namespace {

// The distributions of <random> differ between standard libraries, its engines do not.
float Uniform(std::mt19937& random, float least, float most) {
  return least + (most - least) * static_cast<float>(random() >> 8) * 0x1p-24F;
}

// Of mean 0 and variance 1, by the sum of twelve.
float Normal(std::mt19937& random) {
  float sum = -6.0F;
  for (int i = 0; i < 12; ++i) {
    sum += Uniform(random, 0.0F, 1.0F);
  }
  return sum;
}

}  // namespace

TestImage MakeTestImage() {
  constexpr int kBlock = 12;
  constexpr int kSquare = 5;
  TestImage image;
  std::mt19937 random(5);
  const int blocks = image.width / kBlock + 1;
  std::vector<uint32_t> looks(static_cast<std::size_t>(blocks * (image.height / kBlock + 1)));
  for (uint32_t& look : looks) {
    look = random();
  }
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const int block = y / kBlock * blocks + x / kBlock;
      const uint32_t look = looks[static_cast<std::size_t>(block)];
      const bool inside = (look & 1) != 0 && x % kBlock < kSquare && y % kBlock < kSquare;
      const uint32_t gray = (look >> 24) / 2 + (inside ? 100 : 20) + random() % 8;
      image.pixels.push_back(static_cast<uint8_t>(std::min(gray, 255U)));
    }
  }
  return image;
}

TestFeatures MakeTestFeatures(int count, int64_t descriptor_size) {
  TestImage image;
  std::mt19937 random(6);
  TestFeatures features;
  for (nn::Features* one : {&features.first, &features.second}) {
    one->width = image.width;
    one->height = image.height;
    one->keypoints.resize(count, 2);
    one->scores.resize(count);
    one->descriptors.resize(count, descriptor_size);
  }
  const auto width = static_cast<float>(image.width);
  const auto height = static_cast<float>(image.height);
  for (int i = 0; i < count; ++i) {
    // A multiplication by a number without common factors visits every place once.
    const int other = static_cast<int>(int64_t{7} * i % count);
    nn::Features& first = features.first;
    nn::Features& second = features.second;
    first.keypoints.row(i) << Uniform(random, 4, width - 8), Uniform(random, 4, height - 8);
    second.keypoints.row(other) = first.keypoints.row(i).array() + Uniform(random, 1, 4);
    first.scores[i] = Uniform(random, 0.01F, 0.9F);
    second.scores[other] = Uniform(random, 0.01F, 0.9F);
    for (int64_t c = 0; c < descriptor_size; ++c) {
      first.descriptors(i, c) = Normal(random);
      second.descriptors(other, c) = first.descriptors(i, c) + 0.3F * Normal(random);
    }
    first.descriptors.row(i).normalize();
    second.descriptors.row(other).normalize();
  }
  return features;
}

}  // namespace gluevo::weights_tools
