/* A program that knows nothing of clsdf loads a plug-in that uses it: host PLUGIN. */
#include <dlfcn.h>
#include <stdio.h>

int main(int count, char** arguments) {
    void* plugin = count == 2 ? dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    int (*consumer)(void) = NULL;
    if (plugin != NULL) *(void**)&consumer = dlsym(plugin, "consumer");
    if (consumer == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    return consumer();
}
