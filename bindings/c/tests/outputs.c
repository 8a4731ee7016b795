/* Every output of the library's table has a constant in the header: outputs HEADER, its part basics.h. */
#include "test.h"

#include <ctype.h>

int main(int count, char** arguments) {
    static char text[1 << 18];
    FILE* file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    size_t size;
    int32_t output;
    CHECK(file != NULL);
    size = fread(text, 1, sizeof text - 1, file);
    CHECK(size > 1000 && size < sizeof text - 1);
    fclose(file);
    CHECK(clsdf_output_count() == CLSDF_BODY + 1);
    for (output = 0; output < clsdf_output_count(); ++output) {
        clsdf_output_info info = CLSDF_OUTPUT_INFO_INIT;
        char line[128];
        char* letter;
        if (output == 6) continue; /* none */
        OK(clsdf_output_describe(output, &info));
        CHECK(info.output == output && info.components >= 1 && info.description[0] != 0);
        snprintf(line, sizeof line, "#define CLSDF_%s %d ", info.name, (int)output);
        for (letter = line + strlen("#define "); *letter != 0; ++letter) *letter = (char)toupper(*letter);
        if (strstr(text, line) == NULL) {
            fprintf(stderr, "clsdf/c/basics.h has no line '%s...' for the output %s\n", line, info.name);
            return 1;
        }
    }
    return 0;
}
