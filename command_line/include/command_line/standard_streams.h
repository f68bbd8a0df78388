#pragma once

namespace gluevo::apps {

/// Makes failing output an error that is seen: a full disk and a closed pipe become errors of the
/// write, not signals that end the program, and standard streams that are closed do not pass their
/// numbers on to files.
void PrepareStandardStreams();

/// Throws Error where something could not be printed to standard output.
void CheckStandardOutput();

}  // namespace gluevo::apps
