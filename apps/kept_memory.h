#pragma once

namespace gluevo::apps {

/// From now on memory that is freed stays with the process, but for blocks above 32 MB and what
/// lies free beyond 256 MB at an end of the heap. Images and their pyramids come and go with every
/// frame: given back and asked for again, each costs a page fault every 4 kB, 4 ms a frame with klt
/// at 752 x 480 (a seventh of its processor time). Nothing on systems without glibc.
void KeepFreedMemory();

}  // namespace gluevo::apps
