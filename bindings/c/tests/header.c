/* The headers are C99 on their own. */
#include <clsdf_io.h>

int main(void) {
    return clsdf_version() == CLSDF_VERSION ? 0 : 1;
}
