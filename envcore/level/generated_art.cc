#include "envcore/level/generated_art.h"
