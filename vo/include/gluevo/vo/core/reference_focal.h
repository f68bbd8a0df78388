#pragma once

namespace gluevo::vo {

/// Lengths on the normalised plane z = 1 are given in pixels of a camera with this focal length
/// (pixels), whatever the camera's own: VINS-Fusion's convention, EuRoC's focal length.
inline constexpr double kReferenceFocalPx = 460.0;

/// On the normalised plane.
inline constexpr double FromReferencePx(double px) { return px / kReferenceFocalPx; }

}  // namespace gluevo::vo
