/* A C program that calls C++ code, which uses clsdf. */
int consumer(void);

int main(void) {
    return consumer();
}
