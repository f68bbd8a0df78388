#include "gluevo/vo/dataset.h"
#include "gluevo/vo/evaluation.h"
#include "gluevo/vo/frontend.h"
