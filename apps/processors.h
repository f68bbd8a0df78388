#pragma once

#include <string>
#include <vector>

namespace gluevo::apps {

/// "0,2-3" as numbers of processors, each once, in order. Throws Error for anything else, and for a
/// processor that this process may not use.
std::vector<int> ParseProcessors(const std::string& text);

/// From now on this thread, and the threads that it starts, run on these processors only; nothing
/// where `text` is empty. Throws Error as ParseProcessors.
void UseProcessors(const std::string& text);

/// `asked`, or where that is 0 one for each processor that this thread may use.
int ThreadsOf(int asked);

/// OpenCV's kernels run on at most so many threads, and on no more than there are processors for:
/// TBB below it would say of more, on standard error, that it does not start them.
void UseKernelThreads(int threads);

}  // namespace gluevo::apps
