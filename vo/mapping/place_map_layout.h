#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "gluevo/nn/bytes.h"
#include "gluevo/vo/mapping/place_map.h"

/// The file of a PlaceMap, little endian:
///
///   16 bytes    "gluevo map", then \r \n \x1a \n \0 \0
///   u32         version
///   u32         0
///   u64         size of the body, which is all that follows the checksum
///   64 bytes    SHA-256 of the body, lower-case hexadecimal
///   body:
///     texts     network, source and checksum of the weights; the body frame's name: each a u16
///               length and so many bytes
///     2 cameras u32 width, height, model of distortion (number of vo::Distortion); 12 doubles:
///               fx fy cx cy, 8 coefficients; pose body_from_cam
///     u32       D, values of a descriptor
///     u32       key frames, then each: i64 time (ns), u32 segment, pose world_from_body, pose
///               map_from_body, motion since the key frame before (pose) and its covariance, u32 N
///               keypoints, then N x 2 u16 pixels in the left image, N u16 scores (65535: 1), N x 2
///               u16 pixels in the right image (65535 65535: not seen there), N float inverse
///               depths (1/m, 0: none), N x D i8 descriptors (to be made unit length)
///     u32       loops, then each: u32 candidate, query (key frames), pose candidate_from_query,
///     its
///               covariance, u32 inliers
///
/// A pose is 7 doubles: quaternion x y z w, translation. A covariance is the upper triangle of 6 x
/// 6 doubles, row by row. Pixels are in steps of PixelStep().
namespace gluevo::vo::place_map {

inline constexpr std::string_view kMark("gluevo map\r\n\x1a\n\0\0", 16);
inline constexpr uint32_t kVersion = 2;
inline constexpr std::size_t kChecksumSize = 64;
inline constexpr std::size_t kHeaderSize = kMark.size() + 16 + kChecksumSize;

inline constexpr uint16_t kNotSeen = 65535;
inline constexpr double kScoreSteps = 65535.0;
inline constexpr int kLargestDescriptor = 4096;

/// Bytes of a keypoint without its descriptor, and of a key frame without keypoints.
inline constexpr std::size_t kKeypointSize = 14;
inline constexpr std::size_t kKeyframeSize = 8 + 4 + 3 * 56 + 168 + 4;
inline constexpr std::size_t kLoopSize = 4 + 4 + 56 + 168 + 4;
inline constexpr std::size_t kLargestKeyframe = 118'000;

double PixelStep(const StereoRig& rig);

/// The body of a file whose checksum is right. Throws Error as ParsePlaceMap does.
PlaceMap ParseBody(const nn::Bytes& body, const std::string& source);

}  // namespace gluevo::vo::place_map
